#include "vision/audit/frame_to_frame.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

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

std::vector<Stretch> stretches(const Track& track) {
  std::vector<Stretch> out;
  bool open = false;
  for (const TrackPoint& p : track.points) {
    if (p.status != TrackStatus::ok || !(p.sigma_x > 0 && p.sigma_y > 0)) {
      open = false;
      continue;
    }
    if (!open) out.emplace_back();
    open = true;
    Stretch& s = out.back();
    s.x.push_back(p.x);
    s.y.push_back(p.y);
    s.sigma_x.push_back(p.sigma_x);
    s.sigma_y.push_back(p.sigma_y);
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

LocalPolynomial::LocalPolynomial(int order)
    : half_(static_cast<std::size_t>(order) + 2), weights_(2 * half_ + 1) {
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

std::vector<double> LocalPolynomial::residual(const std::vector<double>& values) const {
  std::vector<double> out;
  for (std::size_t k = 0; k + weights_.size() <= values.size(); ++k) {
    double sum = 0;
    for (std::size_t i = 0; i < weights_.size(); ++i) sum += weights_[i] * values[k + i];
    out.push_back(sum);
  }
  return out;
}

std::vector<double> LocalPolynomial::transposed(const std::vector<double>& residuals,
                                                std::size_t size) const {
  std::vector<double> out(size, 0);
  for (std::size_t k = 0; k < residuals.size(); ++k)
    for (std::size_t i = 0; i < weights_.size(); ++i) out[k + i] += weights_[i] * residuals[k];
  return out;
}

std::vector<double> LocalPolynomial::smoothed(const std::vector<double>& values) const {
  std::vector<double> out = values;
  const std::vector<double> left = residual(values);
  for (std::size_t k = 0; k < left.size(); ++k) out[k + half_] -= left[k];
  return out;
}

/// Of the weights with themselves.
double LocalPolynomial::correlation(std::ptrdiff_t lag) const {
  double sum = 0;
  for (auto i = static_cast<std::size_t>(std::abs(lag)); i < weights_.size(); ++i)
    sum += weights_[i] * weights_[i - static_cast<std::size_t>(std::abs(lag))];
  return sum;
}

double LocalPolynomial::lag1(double rho) const {
  const auto reach = static_cast<std::ptrdiff_t>(weights_.size());
  double same = 0, next = 0;
  for (std::ptrdiff_t lag = -reach; lag <= reach; ++lag) {
    const double of_errors = std::pow(rho, std::abs(lag));
    same += of_errors * correlation(lag);
    next += of_errors * correlation(lag + 1);
  }
  return next / same;
}

namespace {

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

std::optional<Correlation> lag1_correlation(const std::vector<Stretch>& stretches, const Axis& axis,
                                            const LocalPolynomial& fit) {
  constexpr int kLeastPairs = 50;
  std::vector<std::vector<double>> series;
  std::vector<double> all;
  for (const Stretch& s : stretches) {
    std::vector<double>& z = series.emplace_back(fit.residual(s.*axis.position));
    for (std::size_t k = 0; k < z.size(); ++k) z[k] /= (s.*axis.sigma)[k + fit.half()];
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

namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr Eigen::Index kColumns = 4;
/// Power of a column over that of the noise in the positions it is made from: the noise then explains a
/// tenth.
constexpr double kMoving = 10;

/// Columns over the frames of a stretch.
std::vector<std::vector<double>> columns_of(const Stretch& s, const LocalPolynomial& fit) {
  std::vector<std::vector<double>> out(kColumns, std::vector<double>(s.size()));
  const std::vector<double> x = fit.smoothed(s.x), y = fit.smoothed(s.y);
  for (std::size_t k = 0; k < s.size(); ++k) {
    const double px = 2 * std::numbers::pi * x[k], py = 2 * std::numbers::pi * y[k];
    out[0][k] = std::cos(px);
    out[1][k] = std::sin(px);
    out[2][k] = std::cos(py);
    out[3][k] = std::sin(py);
  }
  return out;
}

/// The regression of one coordinate, every row over its standard deviation.
struct Regression {
  MatrixXd filtered;  ///< columns as the polynomial leaves them
  MatrixXd whole;     ///< columns as they are
  MatrixXd spread;    ///< transposed filter of `filtered`: what noise of every frame does to the sums
  VectorXd residual;
  double noise_power = 0;  ///< that the positions' noise gives a column
};

Regression regression_of(const std::vector<Stretch>& stretches, const Axis& axis,
                         const LocalPolynomial& fit) {
  std::vector<std::vector<double>> filtered(kColumns), whole(kColumns), spread(kColumns);
  std::vector<double> residual;
  double noise_power = 0;
  for (const Stretch& s : stretches) {
    if (s.size() <= 2 * fit.half()) continue;
    const auto columns = columns_of(s, fit);
    const std::vector<double>& sd = s.*axis.sigma;
    const std::vector<double> left = fit.residual(s.*axis.position);
    for (std::size_t k = 0; k < left.size(); ++k) residual.push_back(left[k] / sd[k + fit.half()]);
    for (std::size_t c = 0; c < columns.size(); ++c) {
      std::vector<double> part = fit.residual(columns[c]), weighted = part;
      for (std::size_t k = 0; k < part.size(); ++k) {
        part[k] /= sd[k + fit.half()];
        weighted[k] /= sd[k + fit.half()] * sd[k + fit.half()];
      }
      filtered[c].insert(filtered[c].end(), part.begin(), part.end());
      const std::vector<double> back = fit.transposed(weighted, s.size());
      for (std::size_t k = 0; k < s.size(); ++k) {
        whole[c].push_back(columns[c][k] / sd[k]);
        spread[c].push_back(back[k] * sd[k]);
      }
    }
    // d cos(2 pi x) = 2 pi dx, over the standard deviation, at each residual.
    noise_power +=
        4 * std::numbers::pi * std::numbers::pi * fit.smoothed_variance() * static_cast<double>(left.size());
  }
  const auto matrix = [](const std::vector<std::vector<double>>& columns) {
    MatrixXd out(static_cast<Eigen::Index>(columns[0].size()), kColumns);
    for (Eigen::Index c = 0; c < kColumns; ++c)
      out.col(c) = Eigen::Map<const VectorXd>(columns[static_cast<std::size_t>(c)].data(), out.rows());
    return out;
  };
  return {matrix(filtered), matrix(whole), matrix(spread),
          Eigen::Map<const VectorXd>(residual.data(), static_cast<Eigen::Index>(residual.size())),
          noise_power};
}

void leave_out_outliers(Regression& r) {
  const std::vector<double> numbers(r.residual.begin(), r.residual.end());
  const double limit = outlier_size(numbers);
  for (Eigen::Index k = 0; k < r.residual.size(); ++k)
    if (std::abs(r.residual(k)) > limit) r.residual(k) = 0;
}

/// Mean square of the fitted errors beyond that of noise, and its scatter without any.
std::optional<MeanSquare> excess(Regression r, double noise) {
  if (r.residual.size() < 10 * kColumns) return std::nullopt;
  leave_out_outliers(r);
  const SymmetricEigen seen = eigen_symmetric(r.filtered.transpose() * r.filtered);
  const Eigen::Index kept = (seen.values.array() > kMoving * r.noise_power).count();
  if (kept == 0) return std::nullopt;
  const MatrixXd axes = seen.vectors.rightCols(kept);
  const MatrixXd inverse = axes * seen.values.tail(kept).cwiseInverse().asDiagonal() * axes.transpose();
  const VectorXd amplitudes = inverse * (r.filtered.transpose() * r.residual);
  const MatrixXd centred = r.whole.rowwise() - r.whole.colwise().mean();
  const MatrixXd power = centred.transpose() * centred / static_cast<double>(centred.rows());
  const MatrixXd of_noise = noise * power * inverse * (r.spread.transpose() * r.spread) * inverse;
  return MeanSquare{amplitudes.dot(power * amplitudes) - of_noise.trace(),
                    std::sqrt(2 * (of_noise * of_noise).trace())};
}

}  // namespace

std::optional<MeanSquare> pixel_phase(const std::vector<Stretch>& stretches, const Axis& axis,
                                      const LocalPolynomial& fit, double noise) {
  const auto found = excess(regression_of(stretches, axis, fit), noise);
  if (!found) return std::nullopt;
  return MeanSquare{1 + std::max(0.0, found->value), found->scatter};
}

}  // namespace tribotrack::vision
