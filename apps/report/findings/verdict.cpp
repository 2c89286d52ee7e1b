#include "apps/report/findings/verdict.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "apps/page/text.h"

namespace tribotrack::apps {

std::string quoted_interval(const fit::ParameterEstimate& parameter) {
  if (parameter.ci95_pieces.size() < 2)
    return interval_text(parameter.ci95.low, parameter.ci95.high, parameter.sd);
  std::string text;
  for (const fit::Interval& piece : parameter.ci95_pieces)
    text += (text.empty() ? "" : " or ") + interval_text(piece.low, piece.high, parameter.sd);
  return text;
}

std::string subtitle_of(const ReportData& data) {
  std::vector<std::string> facts;
  if (!data.part.empty()) facts.push_back("part " + data.part);
  if (!data.runs.empty()) {
    const auto filmed =
        std::ranges::count_if(data.runs, [](const ReportRun& run) { return !run.video.empty(); });
    facts.push_back(fmt::format("{} run{}{}", data.runs.size(), data.runs.size() == 1 ? "" : "s",
                                filmed > 0 && static_cast<std::size_t>(filmed) < data.runs.size()
                                    ? fmt::format(", {} of them filmed", filmed)
                                    : ""));
  }
  if (!data.filmed.empty()) facts.push_back("filmed " + data.filmed);
  facts.push_back(data.program_version.empty() ? "tribotrack" : "tribotrack " + data.program_version);
  return fmt::format("{}", fmt::join(facts, " · "));
}

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

std::string agreement_text(const fit::FitResult& fit) {
  switch (fit.agreement) {
    case Agreement::only_with_scatter:
      return fmt::format(
          "The measurements deviate from the model by more than their own errors. Scatter of up to {} mm per "
          "axis was added so that χ² agrees: the intervals include it, but χ² no longer tests the model.",
          number(1e3 * fit.scatter, 2));
    case Agreement::unknown:
      return "There are no more data than parameters, so the model could not be checked against them.";
    case Agreement::good:
      return fmt::format(
          "The model describes the measurements within their errors: χ² per degree of freedom is {}; "
          "{} is expected.",
          number(fit.chi2 / fit.dof, 3), expected_chi2_text(fit.dof));
    case Agreement::poor:
      return fmt::format(
          "The measurements deviate from the model by more than their errors: χ² per degree of freedom is "
          "{}, "
          "{} is expected. The residuals show which run or trend does not fit.",
          number(fit.chi2 / fit.dof, 3), expected_chi2_text(fit.dof));
    case Agreement::too_good:
      return fmt::format(
          "The measurements scatter less about the model than their stated errors (χ² per degree of freedom "
          "{}, {} is expected): the stated errors, and with them the intervals, are probably too wide.",
          number(fit.chi2 / fit.dof, 3), expected_chi2_text(fit.dof));
  }
  return "";
}

/// "the data contradict the model, 2 runs failed"; empty where there are none.
std::string reasons_for_care(const ReportData& data) {
  const fit::FitResult& fit = data.fit;
  std::vector<std::string> reasons;
  if (fit.identifiability.verdict == fit::Verdict::weak)
    reasons.push_back("some parameters are determined only weakly");
  if (fit.agreement == Agreement::poor) reasons.push_back("the data contradict the model");
  if (fit.agreement == Agreement::too_good) reasons.push_back("the stated errors look too large");
  if (fit.agreement == Agreement::unknown) reasons.push_back("there are no data left to check the model");
  // The scatter that was added makes chi^2 agree: it must not pass for a test.
  if (fit.agreement == Agreement::only_with_scatter && !fit.slides.empty())
    reasons.push_back(
        fmt::format("free slides deviate from the law of friction by more than their errors (p {})",
                    fit.p_value > 1e-300 ? "= " + number(fit.p_value, 2) : "below 1e-300"));
  if (fit.slides.size() > 1 && fit.between_slides_p_value < 0.05)
    reasons.push_back("μ<sub>1</sub> differs from slide to slide by more than chance");
  if (std::any_of(fit.slides.begin(), fit.slides.end(),
                  [](const fit::SlideResult& slide) { return !slide.blows.empty(); }))
    reasons.push_back("a slide was struck on its way");
  if (!fit.outliers.empty())
    reasons.push_back(fit.outliers.size() == 1
                          ? "one run contradicts the others"
                          : fmt::format("{} runs contradict the others", fit.outliers.size()));
  if (fit.minima.size() > 1) reasons.push_back("other values fit nearly as well");
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
  const fit::FitResult& fit = data.fit;
  Verdict verdict;
  if (!data.fitted()) {
    verdict = {.trust = Trust::no_fit,
               .heading = "Measurements only",
               .paragraph = fmt::format("No parameters were fitted; the page shows what was measured in {}.",
                                        runs_used(data))};
  } else if (!fit.converged) {
    verdict = {.trust = Trust::do_not_use,
               .heading = "Do not use these values",
               .paragraph =
                   "The fit did not converge: the numbers are where it stopped, not a result. "
                   "Check the first guesses and the runs marked below."};
  } else if (fit.identifiability.verdict == fit::Verdict::not_identifiable) {
    verdict = {.trust = Trust::do_not_use,
               .heading = "Do not use these values",
               .paragraph =
                   "These runs do not determine all the parameters: quite different values describe the data "
                   "equally well."};
  } else if (fit.scatter_dominates) {
    verdict = {
        .trust = Trust::do_not_use,
        .heading = "Do not use these values",
        .paragraph = fmt::format("The runs scatter about the model by {} mm per axis, more than a tenth of "
                                 "what they measure: they do not follow it.",
                                 number(1e3 * fit.scatter, 2))};
  } else {
    const bool weak = fit.identifiability.verdict == fit::Verdict::weak;
    const std::string doubts = reasons_for_care(data);
    verdict.trust = doubts.empty() ? Trust::usable : Trust::with_care;
    verdict.heading = doubts.empty() ? "Can be used" : "Use with care: " + doubts;
    verdict.paragraph =
        fmt::format("The fit to {} converged{} {}", runs_used(data),
                    weak ? ", but the data determine some combination of the parameters only weakly."
                         : ", and the data determine every parameter.",
                    agreement_text(fit));
    if (fit.scatter > 0 && fit.agreement != Agreement::only_with_scatter)
      verdict.paragraph += fmt::format(
          " Scatter of {} mm per axis beyond the measurement errors was added; the intervals include it.",
          number(1e3 * fit.scatter, 2));
  }
  if (!data.warnings.empty())
    verdict.paragraph +=
        fmt::format(" Read the {} below first.",
                    data.warnings.size() == 1 ? "warning" : fmt::format("{} warnings", data.warnings.size()));
  return verdict;
}

namespace {

std::string list_of(const std::vector<std::string>& words) {
  std::string text;
  for (std::size_t i = 0; i < words.size(); ++i)
    text += (i == 0 ? "" : i + 1 < words.size() ? ", " : " and ") + words[i];
  return text;
}

bool is_tracked(const ReportRun& run) {
  return run.failure.empty() && run.frames_ok() > 0;
}

std::size_t tracked_runs(const ReportData& data) {
  return static_cast<std::size_t>(std::ranges::count_if(data.runs, is_tracked));
}

bool marker_used(const ReportData& data) {
  return std::ranges::any_of(
      data.runs, [](const ReportRun& run) { return is_tracked(run) && !run.track.in_camera_frame; });
}

std::string version(const ReportData& data) {
  return data.program_version.empty() ? "tribotrack" : "tribotrack " + data.program_version;
}

}  // namespace

std::string methods_text(const ReportData& data) {
  std::string text;
  if (const std::size_t tracked = tracked_runs(data); tracked > 0)
    text += fmt::format(
        "The part's position in {} recording{} was found in every frame by matching of a template "
        "(normalised "
        "cross-correlation) with a standard deviation per point{}. ",
        tracked, tracked == 1 ? "" : "s",
        marker_used(data) ? ", relative to the platform, whose motion was measured in the same frames" : "");
  if (!data.fitted()) return text + fmt::format("Computed with {}.", version(data));
  std::vector<std::string> names;
  for (const fit::ParameterEstimate& p : data.fit.parameters)
    names.push_back(plain_symbol(fit::to_string(p.parameter)));
  text += fmt::format(
      "{} {} estimated by weighted least squares from {} run{}, with the equation of motion of the part "
      "under pulsed dry "
      "friction solved for each run (Kilikevičius et al. 2021, eq. 5) and its exact derivatives; intervals "
      "are 95 %, by {}, "
      "and count {}. Computed with {}.",
      list_of(names), names.size() == 1 ? "was" : "were",
      std::ranges::count_if(data.runs, [](const ReportRun& run) { return run.failure.empty(); }),
      data.runs.size() == 1 ? "" : "s",
      std::ranges::any_of(data.fit.parameters, [](const auto& p) { return !p.profile.empty(); })
          ? "profile likelihood where it differs from the covariance"
          : "the covariance",
      data.fit.budget.empty() ? "the errors of the measurements" : "the sources of the uncertainty budget",
      version(data));
  return text;
}

std::vector<std::string> sources_to_cite(const ReportData& data) {
  return {
      "S. Kilikevičius, K. Liutkauskienė, A. Fedaravičius: Nonprehensile Manipulation of Parts on a "
      "Horizontal "
      "Circularly Oscillating Platform with Dynamic Dry Friction Control. 2021.",
      version(data) + ": friction parameters from high-speed video (see CITATION.cff in its sources)."};
}

}  // namespace tribotrack::apps
