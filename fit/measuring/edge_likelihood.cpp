#include "fit/measuring/edge_likelihood.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numbers>

namespace tribotrack::fit::internal {
namespace {

constexpr double kStray = 1e-4;    ///< probability that a frame means nothing
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

/// The log-likelihood over a range of edges: frames that contribute the same to all of it are summed once.
class LogLikelihood {
 public:
  LogLikelihood(const std::vector<EdgeFrame>& frames, double from, double to, double tau) : tau_(tau) {
    const double margin = 9 * tau;
    for (const EdgeFrame& f : frames) {
      if (f.high < from - margin)
        common_ += std::log(frame_likelihood(f, to + margin, 0));
      else if (f.low > to + margin)
        common_ += std::log(frame_likelihood(f, from - margin, 0));
      else
        frames_.push_back(f);
    }
  }
  double operator()(double edge) const {
    double sum = common_;
    for (const EdgeFrame& f : frames_) sum += std::log(frame_likelihood(f, edge, tau_));
    return sum;
  }

 private:
  std::vector<EdgeFrame> frames_;
  double tau_;
  double common_ = 0;
};

struct Moments {
  Estimate edge;
  double log_evidence = 0;
};

/// Mean and sd within `reach` of `centre`, by the midpoint rule in a window that closes about what is likely.
/// As long as its cells are wider than that they are looked at through a blur of their width.
Moments integrate(const std::vector<EdgeFrame>& frames, double centre, double reach, double tau) {
  constexpr int kPoints = 100, kMostRounds = 12;
  constexpr double kWindow = 7, kWide = 0.5;  // sd to either side; of a window that need not close further
  Moments found;
  for (int round = 0; round < kMostRounds; ++round) {
    const double cell = 2 * reach / kPoints, from = centre - reach;
    const bool last = round + 1 == kMostRounds;
    const auto moments = [&](double blur) {
      const LogLikelihood likelihood(frames, from, centre + reach, blur);
      double log_values[kPoints];
      for (int k = 0; k < kPoints; ++k) log_values[k] = likelihood(from + cell * (k + 0.5));
      const double most = *std::max_element(std::begin(log_values), std::end(log_values));
      double weight = 0, first = 0, second = 0;
      for (int k = 0; k < kPoints; ++k) {
        const double p = std::exp(log_values[k] - most), at = cell * (k + 0.5) - reach;
        weight += p;
        first += p * at;
        second += p * at * at;
      }
      const double mean = first / weight;
      // Each point stands for its cell: its width belongs to the sum.
      const double variance = std::max(0.0, second / weight - mean * mean) + cell * cell / 12;
      return Moments{{centre + mean, std::sqrt(variance)}, most + std::log(weight * cell)};
    };
    found = moments(last ? tau : std::max(tau, cell));
    const double next = kWindow * found.edge.sd;
    if (last || next > kWide * reach) return moments(tau);
    centre = found.edge.value;
    reach = next;
  }
  return found;
}

}  // namespace

EdgeEstimate estimate_edge(const std::vector<EdgeFrame>& frames, double reach, double resolution) {
  const Moments still = integrate(frames, 0, reach, 0);

  // Jitter, where it is worth its while.
  EdgeEstimate best{still.edge, 0};
  double best_evidence = still.log_evidence + kJitterGain;
  double most = still.log_evidence;
  const auto attempt = [&](double tau) {
    const Moments moved = integrate(frames, 0, reach, tau);
    if (moved.log_evidence > best_evidence) {
      best_evidence = moved.log_evidence;
      best = {moved.edge, tau};
    }
    most = std::max(most, moved.log_evidence);
    return moved.log_evidence > most - 25;
  };
  for (double tau = 2 * resolution; tau < 0.5 * reach && attempt(tau); tau *= 2) {
  }
  if (const double tau = best.jitter; tau > 0)
    for (const double factor : {0.6, 0.77, 1.3, 1.6}) attempt(tau * factor);
  return best;
}

}  // namespace tribotrack::fit::internal
