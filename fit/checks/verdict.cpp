#include "fit/checks/verdict.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "fit/tools/parameter_text.h"
#include "fit/tools/statistics.h"
#include "fit/tools/thresholds.h"

namespace tribotrack::fit {

const char* to_string(Agreement agreement) {
  constexpr const char* kNames[] = {"good", "only with scatter", "poor", "too good", "unknown"};
  return kNames[static_cast<std::size_t>(agreement)];
}

const char* to_string(Use use) {
  constexpr const char* kNames[] = {"use", "care", "do_not_use"};
  return kNames[static_cast<std::size_t>(use)];
}

Interval expected_reduced_chi2(int dof, double noise_dof) {
  if (dof < 1) return {};
  const double all = 1 / (1.0 / dof + 1 / noise_dof);
  return {internal::chi2_quantile(0.005, all) / all, internal::chi2_quantile(0.995, all) / all};
}

namespace internal {
namespace {

std::string rejection(const FitResult& result) {
  return fmt::format("the data reject the model as described: chi2 {} at {} degrees of freedom, {}",
                     number(result.chi2, 4), result.dof, chance_text(result.p_value));
}

std::string list_of(const std::vector<std::string>& words) {
  std::string text;
  for (std::size_t i = 0; i < words.size(); ++i)
    text += (i == 0 ? "" : i + 1 < words.size() ? ", " : " and ") + words[i];
  return text;
}

void add_doubts(const FitResult& result, std::vector<std::string>& reasons) {
  if (result.identifiability.verdict == Verdict::weak)
    reasons.push_back("some parameters are determined only weakly");
  if (result.agreement == Agreement::too_good) reasons.push_back("the stated errors look too large");
  if (result.agreement == Agreement::unknown) reasons.push_back("there are no data left to check the model");
  if (result.slides.size() > 1 && result.between_slides.p_value < kDoubt)
    reasons.push_back("mu1 differs from slide to slide by more than chance");
  if (std::ranges::any_of(result.slides, [](const SlideResult& slide) { return !slide.blows.empty(); }))
    reasons.push_back("a slide was struck on its way");
  if (!result.outliers.empty())
    reasons.push_back(result.outliers.size() == 1
                          ? "one run contradicts the others"
                          : fmt::format("{} runs contradict the others", result.outliers.size()));
  reasons.insert(reasons.end(), result.contradicted_priors.begin(), result.contradicted_priors.end());
  if (result.minima.size() > 1) reasons.push_back("other values fit nearly as well");
}

}  // namespace

void judge(FitResult& result) {
  auto& reasons = result.verdict_reasons;
  reasons.clear();
  result.verdict = Use::do_not_use;
  if (!result.converged) reasons.push_back("the fit did not converge: the numbers are where it stopped");
  if (result.identifiability.verdict == Verdict::not_identifiable)
    reasons.push_back(
        "these runs do not determine all the parameters: quite different values describe them as well");
  if (result.scatter_dominates)
    reasons.push_back(fmt::format(
        "the runs scatter about the model by {} mm per axis, more than a tenth of what they measure",
        number(1e3 * result.scatter, 2)));
  const bool rejected = result.p_value < kSurprise;
  const bool repeated = result.scatter_from_replicates;
  // Points of a track err alike for longer than chi^2 knows; their errors are estimated from them.
  const bool tracks = std::ranges::any_of(result.runs, [](const RunResult& run) { return run.points > 0; });
  const bool driven_tracks = tracks && result.slides.empty();
  const bool robust = result.loss != Loss::squares;
  const bool by_tracking = tracks && !(driven_tracks && result.chi2 > kMostOfTracking * result.dof);
  if (rejected && result.quoted_under.empty() && !repeated && !by_tracking && !robust)
    reasons.push_back(rejection(result) + (!result.contradicted_priors.empty()
                                               ? "; " + list_of(result.contradicted_priors)
                                           : result.mistyped ? ""
                                                             : ", and nothing looked at explains it"));
  if (!reasons.empty()) return;
  if (rejected && !result.quoted_under.empty())
    reasons.push_back(rejection(result) + "; the values hold under " + list_of(result.quoted_under));
  else if (rejected && repeated)
    reasons.push_back(
        fmt::format("repeated runs differ by more than their own errors ({}): their scatter is counted",
                    chance_text(result.p_value)));
  else if (rejected && robust)
    reasons.push_back(rejection(result) + "; runs that contradict the others count less");
  else if (rejected)
    reasons.push_back(
        fmt::format("the points deviate from the model by more than their own errors: chi2 {} at {} degrees "
                    "of freedom, {}; "
                    "the intervals count what they share",
                    number(result.chi2, 4), result.dof, chance_text(result.p_value)));
  add_doubts(result, reasons);
  result.verdict = reasons.empty() ? Use::use : Use::care;
}

Agreement agreement(const FitResult& result) {
  const bool surprised = result.p_value < kSurprise;
  if (surprised && result.scatter > 0) return Agreement::only_with_scatter;
  if (!std::isfinite(result.chi2) || result.dof < 1) return Agreement::unknown;
  if (surprised) return Agreement::poor;
  const int least = result.dof - result.conditions;
  // Errors that came from the scatter of points were not stated.
  const bool stated = !std::isfinite(result.noise_dof);
  if (stated && least > 0 && result.chi2 < least * expected_reduced_chi2(least, result.noise_dof).low)
    return Agreement::too_good;
  return Agreement::good;
}

void widen(const std::vector<Explanation>& as_good, FitResult& result) {
  for (ParameterEstimate& p : result.parameters)
    for (const Explanation& other : as_good)
      if (const auto under = other.parameters.find(p.parameter); under != other.parameters.end()) {
        p.ci95.low = std::min(p.ci95.low, under->second.ci95.low);
        p.ci95.high = std::max(p.ci95.high, under->second.ci95.high);
        p.ci95_pieces = {p.ci95};
      }
}

}  // namespace internal
}  // namespace tribotrack::fit
