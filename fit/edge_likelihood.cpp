#include "fit/internal/edge_likelihood.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace tribotrack::fit::internal {
namespace {

constexpr double kStray = 1e-4;    ///< probability that a frame means nothing
constexpr double kDepth = 18;      ///< log-likelihood below the top at which the posterior is cut
constexpr double kJitterGain = 3;  ///< log-likelihood that a jitter has to be worth

double density(double x, double mean, double sigma) {
  const double z = (x - mean) / sigma;
  return std::exp(-0.5 * z * z) / (sigma * std::sqrt(2 * std::numbers::pi));
}

/// P(a < N(0, 1) < b), a <= b.
double between(double a, double b) {
  if (a > 0) return between(-b, -a);  // the smaller tails keep their digits
  return 0.5 * (std::erfc(-b / std::numbers::sqrt2) - std::erfc(-a / std::numbers::sqrt2));
}

/// Likelihood of one frame's level for a mean edge e that jitters by tau: the frame's own likelihood L(e'),
/// constant, then a piece that is normal in e', then constant, convolved with N(e' - e; tau).
double frame_likelihood(const EdgeFrame& f, double e, double tau) {
  const double contrast = std::abs(f.level_above - f.level_below);
  const double below = density(f.level, f.level_below, f.sigma_below);
  const double above = density(f.level, f.level_above, f.sigma_above);
  const double width = f.high - f.low;
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const auto share_within = [&](double from, double to) {
    if (tau > 0) return between((from - e) / tau, (to - e) / tau);
    return e >= from && e < to ? 1.0 : 0.0;
  };
  double sum = below * share_within(-infinity, f.low) + above * share_within(f.high, infinity);
  if (width > 0) {
    if (f.only_inside) {
      sum += share_within(f.low, f.high) / contrast;
    } else {
      // Level = level_below + slope (e' - low): the normal density of the level is one of e' about `centre`.
      const double slope = (f.level_above - f.level_below) / width;
      const double share = std::clamp((f.level - f.level_below) / (f.level_above - f.level_below), 0.0, 1.0);
      const double sigma =
          std::sqrt((1 - share) * f.sigma_below * f.sigma_below + share * f.sigma_above * f.sigma_above);
      const double centre = f.low + (f.level - f.level_below) / slope;
      const double spread = sigma / std::abs(slope);
      if (tau > 0) {
        const double both = std::hypot(spread, tau);
        const double middle = (centre * tau * tau + e * spread * spread) / (both * both);
        const double narrow = spread * tau / both;
        sum += density(e, centre, both) / std::abs(slope) *
               between((f.low - middle) / narrow, (f.high - middle) / narrow);
      } else if (e >= f.low && e < f.high) {
        sum += density(e, centre, spread) / std::abs(slope);
      }
    }
  }
  return (1 - kStray) * sum + kStray / contrast;
}

double log_likelihood(const std::vector<EdgeFrame>& frames, double e, double tau) {
  double sum = 0;
  for (const EdgeFrame& f : frames) sum += std::log(frame_likelihood(f, e, tau));
  return sum;
}

struct Peak {
  double at = 0, log_likelihood = -std::numeric_limits<double>::infinity();
};

Peak best_on_grid(const std::vector<EdgeFrame>& frames, double centre, double reach, int points, double tau) {
  Peak best;
  for (int k = 0; k <= points; ++k) {
    const double e = centre + reach * (2.0 * k / points - 1);
    if (const double l = log_likelihood(frames, e, tau); l > best.log_likelihood) best = {e, l};
  }
  return best;
}

/// From a blurred likelihood to the sharp one: each round looks closer about the last best place.
Peak sharpen(const std::vector<EdgeFrame>& frames, double centre, double reach, double finest, double tau) {
  Peak best{centre};
  for (double span = reach;; span *= 0.35) {
    best = best_on_grid(frames, best.at, span, 60, std::max(tau, span / 25));
    if (span < finest) break;
  }
  return best_on_grid(frames, best.at, finest, 60, tau);
}

struct Moments {
  Estimate edge;
  double log_evidence = 0;
};

/// Where the log-likelihood falls kDepth below the top, going from `at` in one direction.
double foot(const std::vector<EdgeFrame>& frames, const Peak& top, double tau, double direction, double first,
            double reach) {
  double inside = 0, outside = first;
  while (outside < 2 * reach &&
         log_likelihood(frames, top.at + direction * outside, tau) > top.log_likelihood - kDepth) {
    inside = outside;
    outside *= 1.5;
  }
  for (int k = 0; k < 12; ++k) {
    const double middle = 0.5 * (inside + outside);
    (log_likelihood(frames, top.at + direction * middle, tau) > top.log_likelihood - kDepth ? inside
                                                                                            : outside) =
        middle;
  }
  return top.at + direction * outside;
}

/// Mean and sd over the support about the top.
Moments integrate(const std::vector<EdgeFrame>& frames, Peak top, double tau, double first, double reach) {
  const double from = foot(frames, top, tau, -1, first, reach), to = foot(frames, top, tau, 1, first, reach);
  constexpr int points = 600;
  std::vector<double> at(points), log_values(points);
  double most = -std::numeric_limits<double>::infinity();
  for (int k = 0; k < points; ++k) {
    at[k] = from + (to - from) * (k + 0.5) / points;
    log_values[k] = log_likelihood(frames, at[k], tau);
    most = std::max(most, log_values[k]);
  }
  double weight = 0, first_moment = 0, second_moment = 0;
  for (int k = 0; k < points; ++k) {
    const double p = std::exp(log_values[k] - most);
    weight += p;
    first_moment += p * (at[k] - top.at);
    second_moment += p * (at[k] - top.at) * (at[k] - top.at);
  }
  const double mean = first_moment / weight;
  // Points of a box are as far apart as the box is wide over their number: their own width belongs to it.
  const double cell = (to - from) / points;
  const double variance = std::max(0.0, second_moment / weight - mean * mean) + cell * cell / 12;
  return {{top.at + mean, std::sqrt(variance)}, most + std::log(weight * cell)};
}

}  // namespace

EdgeEstimate estimate_edge(const std::vector<EdgeFrame>& frames, double reach, double resolution) {
  const Peak blurred = sharpen(frames, 0, reach, std::max(resolution, 1e-4 * reach), reach / 50);
  const Peak sharp = sharpen(frames, blurred.at, 0.3 * reach, resolution, 0);
  const Moments still = integrate(frames, sharp, 0, resolution, reach);

  // Jitter, where it is worth its while.
  EdgeEstimate best{still.edge, 0};
  double best_evidence = still.log_evidence + kJitterGain;
  for (double tau = 2 * resolution; tau < 0.5 * reach; tau *= 1.7) {
    const Peak top = sharpen(frames, blurred.at, 0.3 * reach, resolution, tau);
    const Moments moved = integrate(frames, top, tau, 0.3 * tau, reach);
    if (moved.log_evidence > best_evidence) {
      best_evidence = moved.log_evidence;
      best = {moved.edge, tau};
    }
  }
  return best;
}

}  // namespace tribotrack::fit::internal
