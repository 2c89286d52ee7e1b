// Effect of errors in quantities that the fit takes as known.
#include <cmath>

#include "fit/report/fill_result.h"
#include "fit/tools/parameter_text.h"

namespace tribotrack::fit::internal {
namespace {

// Shift of a parameter by 1 % of A or w, scaled up from a change small enough to be linear.
constexpr double kChange = 2e-3, kTolerance = 1e-7;

/// The whitened residuals with A or w changed by kChange, or the lag by as many rad; nullopt where the model
/// has no motion there.
std::optional<Eigen::VectorXd> residuals_with(const Residuals& residuals, const Eigen::VectorXd& values,
                                              FitParameter parameter) {
  const Unknowns& unknowns = residuals.unknowns();
  Problem moved = unknowns.problem();
  const double value = unknowns.value_of(parameter, values);
  moved.fixed[parameter] = parameter == FitParameter::lag ? value + kChange : value * (1 + kChange);
  if (parameter == FitParameter::angular_frequency)  // whole cycles end earlier, at the same mean velocity
    for (auto& run : moved.summary_runs) {
      if (run.measured.given_as_velocity) continue;  // the model itself follows
      run.measured.duration /= 1 + kChange;
      run.measured.vector /= 1 + kChange;
    }
  const Unknowns moved_unknowns(moved);
  Residuals whitened(moved_unknowns);
  whitened.set_excess_variance(residuals.excess_variance());
  whitened.set_weights(residuals.weights());
  whitened.set_tolerance(kTolerance);
  Eigen::VectorXd r;
  if (!whitened.evaluate(values, r, nullptr)) return std::nullopt;
  return r;
}

}  // namespace

void fill_systematics(const Residuals& residuals, const Minimum& best, const Uncertainty& uncertainty,
                      FitResult& result) {
  const Unknowns& unknowns = residuals.unknowns();
  if (unknowns.reference_amplitude() <= 0 || uncertainty.rank < unknowns.reported()) return;
  const Eigen::VectorXd values = unknowns.values(best.z);
  const auto add = [&](FitParameter parameter, const char* name) {
    if (unknowns.find(parameter)) return;
    const auto r = residuals_with(residuals, values, parameter);
    if (!r) return;
    // Refit to first order: -(J'J)^-1 J' dr.
    const Eigen::VectorXd shift =
        -uncertainty.full_covariance * (best.jacobian.transpose() * (*r - best.residuals)) * (0.01 / kChange);
    std::string text = std::string(name) + " up 1 %: ";
    for (Eigen::Index i = 0; i < unknowns.reported(); ++i)
      text += (i > 0 ? ", " : "") + change_text(unknowns.parameter(i), shift(i), values(i));
    result.systematics.push_back(text + ".");
  };
  add(FitParameter::amplitude, "A");
  add(FitParameter::angular_frequency, "w");
}

}  // namespace tribotrack::fit::internal
