#include "fit/report/error_text.h"

#include <algorithm>
#include <cmath>

#include "fit/tools/parameter_text.h"
#include "fit/variances/reweighted_fit.h"
#include "fit/variances/robust.h"

namespace tribotrack::fit::internal {

void tell_scatter(const Residuals& residuals, bool allowed, FitResult& result) {
  const Problem& problem = residuals.unknowns().problem();
  const Scatter& scatter = residuals.scatter();
  result.scatter = scatter.runs();
  result.scatter_along = scatter.along;
  result.scatter_across = scatter.across;
  for (const auto& run : scatter.trajectories) result.scatter = std::max(result.scatter, run.between_points);
  if (!any(scatter)) {
    result.covariance_meaning =
        result.loss == Loss::squares
            ? "sd from the data's own sigma (absolute; not scaled by chi2), 95 % intervals with " +
                  std::string(residuals.scatter().slow == SlowVariances{} ? "1.96 sd." : "Student's t.")
            : std::string("95 % intervals with Student's t.") + robust_meaning(result.loss);
    if (result.p_value < kSurprise && !allowed)
      result.warnings.push_back("chi2 = " + number(result.chi2, 4) + " at " + std::to_string(result.dof) +
                                " degrees of freedom (p = " + number(result.p_value, 2) +
                                "): the model or the sigmas are wrong, and the sds too small.");
    return;
  }
  const bool repeated = result.scatter_from_replicates;
  result.covariance_meaning = std::string("sd from the data's own sigma and a scatter estimated from ") +
                              (repeated ? "repeated runs" : "the residuals") +
                              ", added in quadrature; 95 % intervals with Student's t." +
                              robust_meaning(result.loss);
  const std::string size = scatter.along == scatter.across
                               ? number(1e3 * scatter.runs()) + " mm per axis"
                               : number(1e3 * scatter.along) + " mm along (v) and " +
                                     number(1e3 * scatter.across) + " mm across their displacement (alpha)";
  if (repeated)
    result.warnings.push_back("Repeated runs scatter by " + size +
                              " more than their own sigma; with that the "
                              "fit agrees with all runs (p = " +
                              number(result.p_value, 2) + ").");
  else if (scatter.runs() > 0 && result.p_value < kSurprise)
    result.warnings.push_back(
        "The runs scatter by " + size + " more than their own sigma (chi2 " +
        number(result.chi2_before_scatter, 4) + ", p = " + number(result.p_value, 2) + ")" +
        (result.replicate_dof >= 6 ? ", and by more than repeated runs do: " : ": real scatter, or ") +
        "something in A, w, tilt or the model is wrong.");
  for (std::size_t i = 0; i < scatter.trajectories.size(); ++i)
    if (const auto& run = scatter.trajectories[i]; run.between_points > 0)
      result.warnings.push_back("Run '" + problem.trajectory_runs[i].name + "': its points scatter by " +
                                number(1e3 * run.between_points) +
                                " mm per axis more than their own sigma and are correlated over " +
                                number(run.correlation_time, 2) + " points; the sd counts both.");
}

void tell_slow_errors(const Residuals& residuals, FitResult& result) {
  const SlowVariances& variances = residuals.scatter().slow;
  SlowErrors& slow = result.slow_errors;
  slow.time = residuals.slow_reference_time();
  const double own_drift = std::sqrt(variances[static_cast<std::size_t>(SlowPart::drift)]),
               common_drift = std::sqrt(variances[static_cast<std::size_t>(SlowPart::common_drift)]);
  slow.drift = std::hypot(own_drift, common_drift);
  slow.walk = std::sqrt(variances[static_cast<std::size_t>(SlowPart::walk)]);
  slow.circle = std::sqrt(variances[static_cast<std::size_t>(SlowPart::circle)]);
  slow.overtones = std::sqrt(variances[static_cast<std::size_t>(SlowPart::overtones)]);
  slow.common_circle = std::sqrt(variances[static_cast<std::size_t>(SlowPart::common_circle)]);
  slow.common_overtones = std::sqrt(variances[static_cast<std::size_t>(SlowPart::common_overtones)]);
  if (!slow.any()) return;
  std::string parts;
  const auto add = [&](double size, const std::string& what) {
    if (size > 0) parts += (parts.empty() ? "" : ", ") + number(1e6 * size, 2) + " um " + what;
  };
  add(own_drift, "of straight drift over " + number(slow.time, 2) + " s");
  add(slow.walk, "of Brownian walk over " + number(slow.time, 2) + " s");
  add(slow.circle, "at the platform's frequency");
  add(slow.overtones, "at its second and third multiple");
  add(slow.common_circle, "at the platform's frequency in all runs alike");
  add(slow.common_overtones, "at its second and third multiple in all runs alike");
  add(common_drift,
      "of straight drift over " + number(slow.time, 2) + " s along and across the way, in all runs alike");
  // Root mean squares about the mean of a run; a sine's two coefficients add up to one variance.
  const double rms = std::sqrt(slow.drift * slow.drift / 12 + slow.walk * slow.walk / 6 +
                               std::pow(std::hypot(slow.circle, slow.common_circle), 2) +
                               2 * std::pow(std::hypot(slow.overtones, slow.common_overtones), 2));
  if (result.p_value < kSurprise) {
    result.scatter = std::max(result.scatter, rms);
    result.warnings.push_back(
        "The tracks err slowly, by " + number(1e3 * rms) +
        " mm rms per axis beyond their own sigma (p = " + number(result.p_value, 2) +
        "): slow errors of tracking, or something in A, w, tilt or the model is wrong.");
  }
  result.covariance_meaning +=
      " Slow errors that the points of a track share are in it, in every run others unless told to be alike, "
      "of one size estimated from all tracks by restricted maximum likelihood (sd per axis: " +
      parts + "); the intervals count its freedom (Student's t by Satterthwaite).";
}

}  // namespace tribotrack::fit::internal
