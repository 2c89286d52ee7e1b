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
  constexpr double kLeastRatio = 0.3, kMostRatio = 0.98;
  constexpr double kUnseen = 1e-5;  ///< of chi^2: less than the integration's error makes of it
  const double decrement = std::max(options.decrement, kFine);
  const Unknowns& unknowns = place.residuals.unknowns();
  Minimum& best = place.minimum;
  double damping = kFirstDamping, lately = best.chi2;
  Eigen::VectorXd last;  // step
  for (int since = 0; steps > 0 && !best.converged; --steps) {
    const Eigen::MatrixXd jacobian = best.at.scaled(unknowns.slopes(best.z)).jacobian(unknowns.size());
    Eigen::MatrixXd normal = jacobian.transpose() * jacobian;
    const Eigen::VectorXd gradient = jacobian.transpose() * best.at.residuals();
    normal.diagonal() *= 1 + damping;
    Eigen::VectorXd step = -solve_symmetric(normal, gradient);
    const double promised = -step.dot(gradient);
    if (damping <= kFirstDamping && promised < decrement) {
      best.converged = true;
      return true;
    }
    // Steps that follow each other like a geometric series, as where residuals bend, are summed (Aitken).
    const double ratio =
        last.size() > 0 ? (jacobian * step).dot(jacobian * last) / (jacobian * last).squaredNorm() : 0;
    const bool summed = ratio > kLeastRatio && ratio < kMostRatio;
    last = step;
    if (summed) {
      step /= 1 - ratio;
      last.resize(0);
    }
    Place next = full_at(place.residuals, best.z + step, laws);
    const double gain = best.chi2 - next.minimum.chi2;
    if (gain > 0) place = std::move(next);
    // By how far what the linear problem promised was kept (Marquardt; Nielsen 1999).
    if (gain > 0.75 * promised)
      damping = std::max(0.1 * damping, kLeastDamping);
    else if (!(gain > 0.25 * promised) && !summed)
      damping *= gain > 0 ? 3 : 10;
    if (!(gain > 0)) last.resize(0);
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

/// The same until the laws add what they do where it ends; `gently`: they are kept meanwhile.
void settle(Place& place, const MinimiseOptions& options, bool gently) {
  constexpr int kMostTimes = 3;
  constexpr double kSettled = 1e-9, kOff = 0.1;  ///< of chi^2
  const Place start = place;
  int steps = options.full_steps;
  for (int k = 0; gently && k < kMostTimes; ++k) {
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

/// Across kinks of chi^2, where descents end: by steps of 1, 1/2 and 1/4 sd along the axes of the covariance
/// of what is reported (Hooke and Jeeves, J. ACM 8 (1961) 212). The other unknowns follow, to where the
/// problem that is linear there has them.
Place beyond_kinks(Place best) {
  constexpr double kSteps[] = {1, 0.5, 0.25};
  constexpr double kGain = 0.05;  ///< of chi^2: less is not worth a look
  constexpr int kMost = 40;       ///< places looked at
  if (best.minimum.at.empty()) return best;
  const Unknowns& unknowns = best.residuals.unknowns();
  const Eigen::Index reported = unknowns.reported();
  const Linearised by_z = best.minimum.at.scaled(unknowns.slopes(best.minimum.z));
  const Eigen::MatrixXd covariance = shared_covariance(by_z, 1e-14);
  const EigenSystem axes = eigen_symmetric(covariance.topLeftCorner(reported, reported));
  if (!(axes.values(0) > 0) || !std::isfinite(axes.values(reported - 1))) return best;
  int looked = 0;
  const auto look = [&](const Eigen::VectorXd& z) {
    Place there = full_at(best.residuals, z, Residuals::Laws::kept);
    if (there.minimum.at.empty()) return there;
    Eigen::MatrixXd jacobian = there.minimum.at.scaled(unknowns.slopes(z))
                                   .jacobian(unknowns.size())
                                   .rightCols(unknowns.size() - reported);
    Eigen::VectorXd step = Eigen::VectorXd::Zero(unknowns.size());
    step.tail(unknowns.size() - reported) = -solve_symmetric(
        jacobian.transpose() * jacobian, jacobian.transpose() * there.minimum.at.residuals());
    Place moved = full_at(there.residuals, z + step, Residuals::Laws::kept);
    return lower(moved, there) ? moved : there;
  };
  for (const double size : kSteps)
    for (bool found = true; found;) {
      found = false;
      for (Eigen::Index axis = 0; axis < 2 * reported && looked < kMost; ++axis, ++looked) {
        const Eigen::VectorXd along = axes.vectors.col(axis / 2) / std::sqrt(axes.values(axis / 2));
        const Eigen::VectorXd shared = covariance.leftCols(reported) * along;
        const double step = axis % 2 == 0 ? size : -size;
        Place there = look(best.minimum.z + by_z.following(step * shared, unknowns.size()));
        if (!(there.minimum.chi2 < best.minimum.chi2 - kGain)) continue;
        best = std::move(there);
        found = true;
      }
    }
  return best;
}

}  // namespace

Minimum descend_in_full(Residuals& residuals, const Eigen::VectorXd& z, const MinimiseOptions& options) {
  Place place = full_at(residuals, z, Residuals::Laws::anew);
  if (!place.minimum.at.empty()) settle(place, options, true);
  residuals = std::move(place.residuals);
  return place.minimum;
}

Minimum minimise_linearised(Residuals& residuals, const Eigen::VectorXd& z, const MinimiseOptions& options) {
  if (!residuals.linear_in_conditions()) return minimise(residuals, z, options);
  constexpr int kMostTimes = 2;
  constexpr double kKept = 0.01, kOff = 0.3;  ///< of chi^2, of what the linear problem promised
  constexpr double kRough = 0.01;
  constexpr double kNear = 1;  ///< sd
  MinimiseOptions rough = options;
  rough.decrement = std::max(options.decrement, kRough);
  rough.max_iterations = 40;
  rough.patient = false;
  // Each minimum of the linear problem is where it is linearised next, lower or not: kinks are stepped over.
  std::vector<Place> places{full_at(residuals, z, Residuals::Laws::anew)};
  bool kept = false, near = false;
  for (int k = 0; k < kMostTimes && !kept; ++k) {
    const Place& from = places.back();
    const Minimum promised =
        minimise(from.minimum.at.empty() ? residuals : from.residuals, from.minimum.z, rough);
    const double one = std::max(1.0, kKept * promised.chi2);
    places.push_back(full_at(residuals, promised.z, Residuals::Laws::anew));
    const double off = std::abs(places.back().minimum.chi2 - promised.chi2);
    near = off < kOff * one;
    kept = off < kKept * one;
    if (places.back().minimum.at.empty()) break;
  }
  std::ranges::stable_sort(places, lower);
  std::erase_if(places, [](const Place& place) { return place.minimum.at.empty(); });
  if (places.empty()) return full_at(residuals, z, Residuals::Laws::anew).minimum;
  Place best = places.front();
  settle(best, options, near);
  // Where promises are not kept the lowest place need not lead to the lowest minimum.
  if (!kept && options.full_steps == MinimiseOptions{}.full_steps) {
    const auto take = [&](Place other) {
      settle(other, options, near);
      if (!best.minimum.converged || lower(other, best)) best = std::move(other);
    };
    if (places.size() > 1 &&
        !(best.minimum.distance(residuals.unknowns(), places[1].minimum.z) < kNear * kNear))
      take(places[1]);
    const Place beyond = beyond_kinks(best);
    if (lower(beyond, best)) take(full_at(residuals, beyond.minimum.z, Residuals::Laws::anew));
  }
  residuals = best.residuals;
  best.minimum.far_from_linear = !kept;
  return best.minimum;
}

}  // namespace tribotrack::fit::internal
