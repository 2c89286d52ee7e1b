#include "vision/audit/frame_to_frame.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>

#include "vision/kernels/dense.h"
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

MeanSquare without_alternation(const HighFrequency& found, double correlation) {
  const double rho = std::min(0.0, correlation);
  const int p = found.order;
  double larger = 1;
  for (int lag = 1; lag <= p; ++lag)
    larger += 2 * std::pow(-rho, lag) * choose(2 * p, p + lag) / choose(2 * p, p);
  return {found.noise.value / larger, found.noise.scatter / larger};
}

namespace {

/// What is left of a track when a polynomial is fitted about every frame (Savitzky & Golay, Anal. Chem. 36,
/// 1964): least squares over 2 h + 1 frames, taken at the middle one.
class LocalPolynomial {
 public:
  /// For a motion that differences of this order do not show (high_frequency): that degree, over twice the
  /// frames it needs, which leaves most of the noise.
  explicit LocalPolynomial(int order) : half_(static_cast<std::size_t>(order) + 2), weights_(2 * half_ + 1) {
    const auto count = static_cast<Eigen::Index>(weights_.size());
    Eigen::MatrixXd powers(count, order + 1);
    for (Eigen::Index i = 0; i < count; ++i) {
      const double t = static_cast<double>(i) / static_cast<double>(half_) - 1;
      for (Eigen::Index d = 0; d <= order; ++d) powers(i, d) = std::pow(t, d);
    }
    const Eigen::MatrixXd fit =
        solve_spd(powers.transpose() * powers, powers.transpose());  // row 0: the value at t = 0
    for (Eigen::Index i = 0; i < count; ++i) weights_[static_cast<std::size_t>(i)] = -fit(0, i);
    weights_[half_] += 1;
  }

  std::size_t half() const { return half_; }

  /// At every frame but the first and last `half`: the value less the polynomial's.
  std::vector<double> residual(const std::vector<double>& values) const {
    std::vector<double> out;
    for (std::size_t k = 0; k + weights_.size() <= values.size(); ++k) {
      double sum = 0;
      for (std::size_t i = 0; i < weights_.size(); ++i) sum += weights_[i] * values[k + i];
      out.push_back(sum);
    }
    return out;
  }

  /// Correlation of consecutive residuals of errors each of which is `rho` times the last and white noise.
  double lag1(double rho) const {
    const auto reach = static_cast<std::ptrdiff_t>(weights_.size());
    double same = 0, next = 0;
    for (std::ptrdiff_t lag = -reach; lag <= reach; ++lag) {
      const double of_errors = std::pow(rho, std::abs(lag));
      same += of_errors * correlation(lag);
      next += of_errors * correlation(lag + 1);
    }
    return next / same;
  }

 private:
  /// Of the weights with themselves.
  double correlation(std::ptrdiff_t lag) const {
    const auto distance = static_cast<std::size_t>(std::abs(lag));
    double sum = 0;
    for (std::size_t i = distance; i < weights_.size(); ++i) sum += weights_[i] * weights_[i - distance];
    return sum;
  }

  std::size_t half_;
  std::vector<double> weights_;  ///< of the residual
};

/// The rho that leaves residuals correlated like this, by bisection.
double autoregression(const LocalPolynomial& fit, double residual_correlation) {
  double low = -1, high = 1;
  while (high - low > 1e-6) {
    const double rho = 0.5 * (low + high);
    (fit.lag1(rho) < residual_correlation ? low : high) = rho;
  }
  return 0.5 * (low + high);
}

}  // namespace

std::optional<Correlation> lag1_correlation(const std::vector<TrackStretch>& stretches, int order) {
  constexpr int kLeastPairs = 50;
  const LocalPolynomial fit(order);
  std::vector<std::vector<double>> series;
  std::vector<double> all;
  for (const TrackStretch& s : stretches) {
    std::vector<double>& z = series.emplace_back(fit.residual(s.position));
    for (std::size_t k = 0; k < z.size(); ++k) z[k] /= s.sigma[k + fit.half()];
    all.insert(all.end(), z.begin(), z.end());
  }
  const double limit = outlier_size(all);
  double product = 0, square = 0;
  int pairs = 0;
  for (const std::vector<double>& z : series)
    for (std::size_t k = 1; k < z.size(); ++k) {
      if (std::abs(z[k - 1]) > limit || std::abs(z[k]) > limit) continue;
      product += z[k - 1] * z[k];
      square += 0.5 * (z[k - 1] * z[k - 1] + z[k] * z[k]);
      ++pairs;
    }
  if (pairs < kLeastPairs || !(square > 0)) return std::nullopt;
  return Correlation{autoregression(fit, product / square), 1 / std::sqrt(pairs)};
}

}  // namespace tribotrack::vision
