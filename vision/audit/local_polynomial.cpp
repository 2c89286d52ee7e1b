#include "vision/audit/local_polynomial.h"

#include <Eigen/Dense>
#include <cmath>

#include "vision/audit/mean_square.h"

namespace tribotrack::vision {

LocalPolynomial::LocalPolynomial(int order)
    : half_(static_cast<std::size_t>(order) + 2), weights_(2 * half_ + 1) {
  const auto count = static_cast<Eigen::Index>(weights_.size());
  Eigen::MatrixXd powers(count, order + 1);
  for (Eigen::Index i = 0; i < count; ++i) {
    const double t = static_cast<double>(i) / static_cast<double>(half_) - 1;
    for (Eigen::Index d = 0; d <= order; ++d) powers(i, d) = std::pow(t, d);
  }
  const Eigen::MatrixXd fit =
      (powers.transpose() * powers).ldlt().solve(powers.transpose());  // row 0: the value at t = 0
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

}  // namespace tribotrack::vision
