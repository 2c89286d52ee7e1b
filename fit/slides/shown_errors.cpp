#include "fit/slides/shown_errors.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "fit/tools/statistics.h"
#include "fit/tools/thresholds.h"

namespace tribotrack::fit::internal {
namespace {

constexpr std::size_t kFewestResiduals = 16;
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kOfParabola = 3;  ///< unknowns along the slide
/// A normal variable exceeds it with probability kSurprise.
constexpr double kFar = 3.09;

/// Sum of e_k e_k+lag.
double product(const std::vector<double>& e, std::size_t lag) {
  double sum = 0;
  for (std::size_t k = 0; k + lag < e.size(); ++k) sum += e[k] * e[k + lag];
  return sum;
}

/// Per axis, of one point.
double mean_variance(const TrackTable& track) {
  double sum = 0;
  for (const Eigen::Matrix2d& covariance : track.covariance) sum += 0.5 * covariance.trace();
  return sum / static_cast<double>(track.covariance.size());
}

/// Share of the track's variance that its own slow errors have in common at so many seconds.
double told_correlation(const TrackTable& track, double apart) {
  const double variance = mean_variance(track);
  double told = 0;
  for (const SlowError& slow : track.slow) told += slow.sd * slow.sd * std::exp(-apart / slow.time);
  return variance > 0 ? told / variance : 0;
}

}  // namespace

std::optional<ShownErrors> shown_errors(const TrackTable& track, const SlideResiduals& residuals) {
  const std::vector<double>& e = residuals.value;
  const std::size_t n = e.size();
  if (n < kFewestResiduals) return std::nullopt;
  const double length = residuals.time.back() - residuals.time.front(),
               step = length / static_cast<double>(n - 1), square = product(e, 0);
  if (!(square > 0) || !(step > 0)) return std::nullopt;
  const double next = product(e, 1) / square;
  if (next - told_correlation(track, step) < kFar / std::sqrt(static_cast<double>(n))) return std::nullopt;

  double steps = 0;
  for (std::size_t k = 0; k + 1 < n; ++k) steps += std::pow(e[k + 1] - e[k], 2);
  const double all = square / static_cast<double>(n - 3);
  const double own = std::min(all, steps / (2 * static_cast<double>(n - 1)));
  // Of white noise, (e_k+1 - e_k)^2 / 2 has a mean with a relative variance of 3/n.
  const double told_own = mean_variance(track) * (1 - told_correlation(track, 0));
  if (own > told_own * (1 - kFar * std::sqrt(3 / static_cast<double>(n)))) return std::nullopt;
  std::size_t lag = 1;
  while (lag + 1 < n && product(e, lag) > next * square / std::numbers::e) ++lag;
  const double time = static_cast<double>(lag) * step;
  // So many independent values there are in a process of this correlation time.
  const double independent = std::max(length / (2 * time), 1.5 * kOfParabola);
  const double left = independent - kOfParabola;
  const double unsure = two_sided_quantile(0.95, left) / two_sided_quantile(0.95, kInfinity);
  const double slow = (all - own) * independent / left * unsure * unsure;
  return ShownErrors{std::sqrt(own), {std::sqrt(slow), time}};
}

void take_errors(const ShownErrors& shown, TrackTable& track) {
  const double variance = shown.own_sd * shown.own_sd + shown.slow.sd * shown.slow.sd;
  track.covariance.assign(track.time.size(), variance * Eigen::Matrix2d::Identity());
  track.slow = {shown.slow};
  track.shared.clear();
}

}  // namespace tribotrack::fit::internal
