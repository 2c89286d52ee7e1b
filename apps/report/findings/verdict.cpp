#include "apps/report/findings/verdict.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "apps/page/text.h"

namespace tribotrack::apps {
namespace {

using fit::Agreement;

std::size_t failed_runs(const ReportData& data) {
  return static_cast<std::size_t>(std::count_if(data.runs.begin(), data.runs.end(),
                                                [](const ReportRun& run) { return !run.failure.empty(); }));
}

std::string runs_used(const ReportData& data) {
  const std::size_t failed = failed_runs(data);
  const std::size_t used = data.runs.size() - failed;
  std::string text = fmt::format("{} run{}", used, used == 1 ? "" : "s");
  if (failed > 0)
    text += fmt::format(" ({} more failed and {} left out)", failed, failed == 1 ? "is" : "are");
  return text;
}

std::string agreement_text(const ReportData& data) {
  switch (data.agreement) {
    case Agreement::only_with_scatter:
      return fmt::format(
          "The measurements deviate from the model by more than their own errors. Scatter of up to {} mm per "
          "axis was added so that χ² agrees: the intervals include it, but χ² no longer tests the model.",
          number(data.scatter_mm, 2));
    case Agreement::unknown:
      return "There are no more data than parameters, so the model could not be checked against them.";
    case Agreement::good:
      return fmt::format(
          "The model describes the measurements within their errors: χ² per degree of freedom is {}; "
          "{} is expected.",
          number(data.chi2 / data.dof, 3), expected_chi2_text(data.dof));
    case Agreement::poor:
      return fmt::format(
          "The measurements deviate from the model by more than their errors: χ² per degree of freedom is "
          "{}, "
          "{} is expected. The residuals show which run or trend does not fit.",
          number(data.chi2 / data.dof, 3), expected_chi2_text(data.dof));
    case Agreement::too_good:
      return fmt::format(
          "The measurements scatter less about the model than their stated errors (χ² per degree of freedom "
          "{}, {} is expected): the stated errors, and with them the intervals, are probably too wide.",
          number(data.chi2 / data.dof, 3), expected_chi2_text(data.dof));
  }
  return "";
}

/// "the data contradict the model, 2 runs failed"; empty where there are none.
std::string reasons_for_care(const ReportData& data) {
  std::vector<std::string> reasons;
  if (data.identifiability == ReportVerdict::weak)
    reasons.push_back("some parameters are determined only weakly");
  if (data.agreement == Agreement::poor) reasons.push_back("the data contradict the model");
  if (data.agreement == Agreement::too_good) reasons.push_back("the stated errors look too large");
  if (data.agreement == Agreement::unknown) reasons.push_back("there are no data left to check the model");
  // The scatter that was added makes chi^2 agree: it must not pass for a test.
  if (data.agreement == Agreement::only_with_scatter && !data.slide_results.empty())
    reasons.push_back(
        fmt::format("free slides deviate from the law of friction by more than their errors (p {})",
                    data.p_value > 1e-300 ? "= " + number(data.p_value, 2) : "below 1e-300"));
  if (data.between_slides_p_value < 0.05)
    reasons.push_back("μ<sub>1</sub> differs from slide to slide by more than chance");
  if (std::any_of(data.slide_results.begin(), data.slide_results.end(),
                  [](const ReportSlideResult& slide) { return !slide.blow_frames.empty(); }))
    reasons.push_back("a slide was struck on its way");
  if (!data.outliers.empty())
    reasons.push_back(data.outliers.size() == 1
                          ? "one run contradicts the others"
                          : fmt::format("{} runs contradict the others", data.outliers.size()));
  if (!data.other_minima.empty()) reasons.push_back("other values fit nearly as well");
  const std::size_t failed = failed_runs(data);
  if (failed > 0) reasons.push_back(failed == 1 ? "one run failed" : fmt::format("{} runs failed", failed));
  std::string text;
  for (const std::string& reason : reasons) text += fmt::format("{}{}", text.empty() ? "" : ", ", reason);
  return text;
}

}  // namespace

std::string expected_chi2_text(int dof) {
  const fit::Interval expected = fit::expected_reduced_chi2(dof);
  return interval_text(expected.low, expected.high, 0.3 * (expected.high - expected.low));
}

Verdict verdict_of(const ReportData& data) {
  Verdict verdict;
  if (!data.fitted || data.parameters.empty()) {
    verdict = {.trust = Trust::no_fit,
               .heading = "Measurements only",
               .paragraph = fmt::format("No parameters were fitted; the page shows what was measured in {}.",
                                        runs_used(data))};
  } else if (!data.converged) {
    verdict = {.trust = Trust::do_not_use,
               .heading = "Do not use these values",
               .paragraph =
                   "The fit did not converge: the numbers are where it stopped, not a result. "
                   "Check the first guesses and the runs marked below."};
  } else if (data.identifiability == ReportVerdict::not_identifiable) {
    verdict = {.trust = Trust::do_not_use,
               .heading = "Do not use these values",
               .paragraph =
                   "These runs do not determine all the parameters: quite different values describe the data "
                   "equally well."};
  } else if (data.scatter_dominates) {
    verdict = {
        .trust = Trust::do_not_use,
        .heading = "Do not use these values",
        .paragraph = fmt::format("The runs scatter about the model by {} mm per axis, more than a tenth of "
                                 "what they measure: they do not follow it.",
                                 number(data.scatter_mm, 2))};
  } else {
    const bool weak = data.identifiability == ReportVerdict::weak;
    const std::string doubts = reasons_for_care(data);
    verdict.trust = doubts.empty() ? Trust::usable : Trust::with_care;
    verdict.heading = doubts.empty() ? "Can be used" : "Use with care: " + doubts;
    verdict.paragraph =
        fmt::format("The fit to {} converged{} {}", runs_used(data),
                    weak ? ", but the data determine some combination of the parameters only weakly."
                         : ", and the data determine every parameter.",
                    agreement_text(data));
    if (data.scatter_mm > 0 && data.agreement != Agreement::only_with_scatter)
      verdict.paragraph += fmt::format(
          " Scatter of {} mm per axis beyond the measurement errors was added; the intervals include it.",
          number(data.scatter_mm, 2));
  }
  if (!data.warnings.empty())
    verdict.paragraph +=
        fmt::format(" Read the {} below first.",
                    data.warnings.size() == 1 ? "warning" : fmt::format("{} warnings", data.warnings.size()));
  return verdict;
}

}  // namespace tribotrack::apps
