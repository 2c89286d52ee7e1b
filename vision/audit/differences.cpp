#include "vision/audit/differences.h"

#include <algorithm>
#include <cmath>

namespace tribotrack::vision {
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
void add_differences(const std::vector<double>& position, const std::vector<double>& sigma, int p,
                     std::vector<double>& out) {
  const auto order = static_cast<std::size_t>(p);
  for (std::size_t k = 0; k + order < position.size(); ++k) {
    double difference = 0, variance = 0;
    for (std::size_t i = 0; i <= order; ++i) {
      const double c = choose(p, static_cast<int>(i)) * (i % 2 == 0 ? 1 : -1);
      difference += c * position[k + i];
      variance += c * c * sigma[k + i] * sigma[k + i];
    }
    out.push_back(difference / std::sqrt(variance));
  }
}

struct OfOrder {
  double square = 0;
  double count = 0;
};

OfOrder of_order(const std::vector<Stretch>& stretches, const Axis& axis, int p) {
  std::vector<double> differences;
  for (const Stretch& s : stretches) add_differences(s.*axis.position, s.*axis.sigma, p, differences);
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

std::optional<HighFrequency> high_frequency(const std::vector<Stretch>& stretches, const Axis& axis) {
  OfOrder low = of_order(stretches, axis, 2);
  for (int p = 2; p <= kHighestOrder; p += 2) {
    const OfOrder next = of_order(stretches, axis, p + 2);
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

MeanSquare without_alternation(const HighFrequency& found, double correlation) {
  const double rho = std::min(0.0, correlation);
  const int p = found.order;
  double larger = 1;
  for (int lag = 1; lag <= p; ++lag)
    larger += 2 * std::pow(-rho, lag) * choose(2 * p, p + lag) / choose(2 * p, p);
  return {found.noise.value / larger, found.noise.scatter / larger};
}

}  // namespace tribotrack::vision
