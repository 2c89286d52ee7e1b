#include "vision/audit/frame_to_frame.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "vision/kernels/median.h"

namespace tribotrack::vision {

double outlier_size(const std::vector<double>& numbers) {
  constexpr double kFar = 5;
  constexpr double kMostOutliers = 0.25;
  std::vector<double> sizes;
  for (const double z : numbers) sizes.push_back(std::abs(z));
  const double limit = kFar * kNormalMad * median(sizes);
  double beyond = 0;
  for (const double size : sizes) beyond += size > limit;
  return beyond > kMostOutliers * static_cast<double>(sizes.size()) ? std::numeric_limits<double>::infinity()
                                                                    : limit;
}

double supported(const MeanSquare& found) {
  const double excess = found.value - 1;
  const double doubt = 2 * found.scatter;
  if (!(excess > doubt)) return 1;
  return 1 + excess - doubt * doubt / excess;
}

std::vector<TrackStretch> stretches(const Track& track, double TrackPoint::*position,
                                    double TrackPoint::*sigma) {
  std::vector<TrackStretch> out;
  bool open = false;
  for (const TrackPoint& p : track.points) {
    if (p.status != TrackStatus::ok || !(p.sigma_x > 0 && p.sigma_y > 0)) {
      open = false;
      continue;
    }
    if (!open) out.emplace_back();
    open = true;
    out.back().position.push_back(p.*position);
    out.back().sigma.push_back(p.*sigma);
  }
  return out;
}

namespace {

constexpr std::size_t kLeastDifferences = 24;  ///< a ratio of standard deviations to 20 %
constexpr int kHighestOrder = 6;
/// Standard deviations by which orders must differ: fewer, and white noise is often taken for a motion; more,
/// and a motion passes for noise.
constexpr double kCertain = 3;

double choose(int n, int k) {
  double out = 1;
  for (int i = 1; i <= k; ++i) out = out * (n - k + i) / i;
  return out;
}

/// Appends the p-th differences over what their standard deviation would be.
void add_differences(const TrackStretch& s, int p, std::vector<double>& out) {
  const auto order = static_cast<std::size_t>(p);
  for (std::size_t k = 0; k + order < s.position.size(); ++k) {
    double difference = 0, variance = 0;
    for (std::size_t i = 0; i <= order; ++i) {
      const double c = choose(p, static_cast<int>(i)) * (i % 2 == 0 ? 1 : -1);
      difference += c * s.position[k + i];
      variance += c * c * s.sigma[k + i] * s.sigma[k + i];
    }
    out.push_back(difference / std::sqrt(variance));
  }
}

struct OfOrder {
  double square = 0;
  double count = 0;
};

OfOrder of_order(const std::vector<TrackStretch>& stretches, int p) {
  std::vector<double> differences;
  for (const TrackStretch& s : stretches) add_differences(s, p, differences);
  const double limit = outlier_size(differences);
  OfOrder out;
  for (const double z : differences) {
    if (std::abs(z) > limit) continue;
    out.square += z * z;
    ++out.count;
  }
  if (out.count > 0) out.square /= out.count;
  return out;
}

/// Covariance of two orders' estimates from n differences, relative.
double covariance(int p, int q, double n) {
  return 2 / n * choose(2 * (p + q), p + q) / (choose(2 * p, p) * choose(2 * q, q));
}

}  // namespace

std::optional<HighFrequency> high_frequency(const std::vector<TrackStretch>& stretches) {
  OfOrder low = of_order(stretches, 2);
  for (int p = 2; p <= kHighestOrder; p += 2) {
    const OfOrder next = of_order(stretches, p + 2);
    if (next.count < kLeastDifferences) return std::nullopt;
    const double n = next.count;
    const double scatter =
        std::sqrt(covariance(p, p, n) + covariance(p + 2, p + 2, n) - 2 * covariance(p, p + 2, n));
    if (low.square <= next.square * (1 + kCertain * scatter))
      return HighFrequency{{low.square, low.square * std::sqrt(covariance(p, p, n))}, p};
    low = next;
  }
  return std::nullopt;
}

}  // namespace tribotrack::vision
