// The minimum of the full model, from that of the problem that is linear in the conditions.
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "fit/minimum/minimise.h"
#include "fit/tools/dense.h"
#include "fit/tools/thresholds.h"

namespace tribotrack::fit::internal {
namespace {

struct Place {
  Minimum minimum;
  Residuals residuals;  ///< linearised there
};

/// The full model at z; at infinity without a motion.
Place full_at(const Residuals& residuals, const Eigen::VectorXd& z, Residuals::Laws laws) {
  Place place{{}, residuals};
  place.minimum.z = z;
  place.minimum.chi2 = std::numeric_limits<double>::infinity();
  const Eigen::VectorXd values = residuals.unknowns().values(z);
  if (!values.allFinite() || !place.residuals.linearise(values, laws)) return place;
  if (auto at = place.residuals.at(values)) {
    place.minimum.chi2 = at->chi2();
    place.minimum.at = std::move(*at);
  }
  return place;
}

bool lower(const Place& a, const Place& b) {
  return a.minimum.chi2 < b.minimum.chi2;
}

/// Levenberg and Marquardt's method in the full model, with `steps` left to it. False where it ends at a
/// kink.
bool descend(Place& place, const MinimiseOptions& options, Residuals::Laws laws, int& steps) {
  constexpr double kFine = 1e-11, kFirstDamping = 1e-4, kLeastDamping = 1e-6, kMostDamping = 1e3;
  constexpr int kPatience = 5;
  constexpr double kLittle = 1e-3;  ///< of chi^2, in as many steps: at a kink the last digits come slowly
  constexpr double kUnseen = 1e-5;  ///< of chi^2: less than the integration's error makes of it
  const double decrement = std::max(options.decrement, kFine);
  const Unknowns& unknowns = place.residuals.unknowns();
  Minimum& best = place.minimum;
  double damping = kFirstDamping, lately = best.chi2;
  for (int since = 0; steps > 0 && !best.converged; --steps) {
    const Eigen::MatrixXd jacobian = best.at.scaled(unknowns.slopes(best.z)).jacobian(unknowns.size());
    Eigen::MatrixXd normal = jacobian.transpose() * jacobian;
    const Eigen::VectorXd gradient = jacobian.transpose() * best.at.residuals();
    normal.diagonal() *= 1 + damping;
    const Eigen::VectorXd step = -solve_symmetric(normal, gradient);
    const double promised = -step.dot(gradient);
    if (damping <= kFirstDamping && promised < decrement) {
      best.converged = true;
      return true;
    }
    Place next = full_at(place.residuals, best.z + step, laws);
    const double gain = best.chi2 - next.minimum.chi2;
    if (gain > 0) place = std::move(next);
    // By how far what the linear problem promised was kept (Marquardt; Nielsen 1999).
    if (gain > 0.75 * promised)
      damping = std::max(0.1 * damping, kLeastDamping);
    else if (!(gain > 0.25 * promised))
      damping *= gain > 0 ? 3 : 10;
    best.converged =
        damping > kMostDamping || (gain > 0 ? gain < decrement : promised < std::max(decrement, kUnseen));
    const bool full_step = damping <= kFirstDamping && gain > 0.25 * promised;
    if (full_step || lately - best.chi2 > kLittle) lately = best.chi2, since = 0;
    if (!best.converged && ++since > kPatience) {
      best.converged = true;
      return false;
    }
  }
  best.converged |= lately - best.chi2 < kNearMinimum;
  return steps > 0;
}

/// The same with what the laws add kept, until it is that where it ends, too.
void settle(Place& place, const MinimiseOptions& options) {
  constexpr int kMostTimes = 3;
  constexpr double kSettled = 1e-9, kOff = 0.1;  ///< of chi^2
  const Place start = place;
  int steps = options.full_steps;
  for (int k = 0; k < kMostTimes; ++k) {
    const bool smooth = descend(place, options, Residuals::Laws::kept, steps);
    Place there = full_at(place.residuals, place.minimum.z, Residuals::Laws::anew);
    const double off = std::abs(there.minimum.chi2 - place.minimum.chi2);
    there.minimum.converged = place.minimum.converged;
    if (!(off < kOff)) {
      place = lower(there, start) ? there : start;
      break;
    }
    place = std::move(there);
    if (!smooth || newton_decrement(place.minimum.at) < std::max(options.decrement, kSettled)) return;
    if (k + 1 == kMostTimes) return;
    place.minimum.converged = false;
  }
  place.minimum.converged = false;
  steps = options.full_steps;
  descend(place, options, Residuals::Laws::anew, steps);
}

}  // namespace

Minimum minimise_linearised(Residuals& residuals, const Eigen::VectorXd& z, const MinimiseOptions& options) {
  if (!residuals.linear_in_conditions()) return minimise(residuals, z, options);
  Place place = full_at(residuals, z, Residuals::Laws::anew);
  if (!place.minimum.at.empty()) settle(place, options);
  residuals = std::move(place.residuals);
  return place.minimum;
}

}  // namespace tribotrack::fit::internal
