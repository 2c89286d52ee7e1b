// The minimum of the full model: each step by the problem that is linear where the last one ended.
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "fit/minimum/minimise.h"
#include "fit/minimum/multi_start.h"
#include "fit/tools/dense.h"
#include "fit/tools/thresholds.h"

namespace tribotrack::fit::internal {
namespace {

struct Place {
  Minimum minimum;
  Residuals residuals;  ///< linearised there
};

/// The full model at z; at infinity without a motion.
Place full_at(const Residuals& residuals, const Eigen::VectorXd& z) {
  Place place{{}, residuals};
  place.minimum.z = z;
  place.minimum.chi2 = std::numeric_limits<double>::infinity();
  const Eigen::VectorXd values = residuals.unknowns().values(z);
  if (!values.allFinite() || !place.residuals.linearise(values)) return place;
  if (auto at = place.residuals.at(values)) {
    place.minimum.chi2 = at->chi2();
    place.minimum.at = std::move(*at);
  }
  return place;
}

/// Levenberg and Marquardt's method in the full model. It ends at a kink, too.
void descend(Place& place, const MinimiseOptions& options) {
  constexpr double kFine = 1e-11, kFirstDamping = 1e-4, kLeastDamping = 1e-6, kMostDamping = 1e3;
  constexpr int kPatience = 5;
  constexpr double kLittle = 1e-3;  ///< of chi^2, in as many steps: at a kink the last digits come slowly
  constexpr double kUnseen = 1e-5;  ///< of chi^2: less than the integration's error makes of it
  const double decrement = std::max(options.decrement, kFine);
  const Unknowns& unknowns = place.residuals.unknowns();
  Minimum& best = place.minimum;
  double damping = kFirstDamping, lately = best.chi2;
  for (int step_count = 0, since = 0; step_count < options.full_steps && !best.converged; ++step_count) {
    const Eigen::MatrixXd jacobian = best.at.scaled(unknowns.slopes(best.z)).jacobian(unknowns.size());
    Eigen::MatrixXd normal = jacobian.transpose() * jacobian;
    const Eigen::VectorXd gradient = jacobian.transpose() * best.at.residuals();
    normal.diagonal() *= 1 + damping;
    const Eigen::VectorXd step = -solve_symmetric(normal, gradient);
    const double promised = -step.dot(gradient);
    if (damping <= kFirstDamping && promised < decrement) {
      best.converged = true;
      break;
    }
    Place next = full_at(place.residuals, best.z + step);
    const double gain = best.chi2 - next.minimum.chi2;
    if (gain > 0) place = std::move(next);
    // By how far what the linear problem promised was kept (Marquardt; Nielsen 1999).
    if (gain > 0.75 * promised)
      damping = std::max(0.1 * damping, kLeastDamping);
    else if (!(gain > 0.25 * promised))
      damping *= gain > 0 ? 3 : 10;
    const bool full_step = damping <= kFirstDamping && gain > 0.25 * promised;
    if (full_step || lately - best.chi2 > kLittle) lately = best.chi2, since = 0;
    best.converged = ++since > kPatience || damping > kMostDamping ||
                     std::max(gain, promised) < std::max(decrement, kUnseen);
  }
  best.converged |= lately - best.chi2 < kNearMinimum;
}

}  // namespace

Minimum minimise_linearised(Residuals& residuals, const Eigen::VectorXd& z, const MinimiseOptions& options) {
  const Unknowns& unknowns = residuals.unknowns();
  if (!residuals.linear_in_conditions()) {
    Minimum minimum = minimise(residuals, z, options);
    minimum.z = fold_lag(unknowns, minimum.z);
    return minimum;
  }
  Place place = full_at(residuals, z);
  if (!place.minimum.at.empty()) descend(place, options);
  // Where pulses do little the search may go round.
  if (const Eigen::VectorXd folded = fold_lag(unknowns, place.minimum.z); folded != place.minimum.z) {
    const bool converged = place.minimum.converged;
    place = full_at(place.residuals, folded);
    place.minimum.converged = converged;
  }
  residuals = std::move(place.residuals);
  return place.minimum;
}

}  // namespace tribotrack::fit::internal
