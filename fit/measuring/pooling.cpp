#include "fit/pooling.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <vector>

#include "fit/tools/statistics.h"

namespace tribotrack::fit {
namespace {

/// Variance of a run's own: without what all share.
double own_variance(const Estimate& value, double common_sd) {
  if (!(value.sd >= 0) || !std::isfinite(value.sd) || !std::isfinite(value.value))
    throw std::invalid_argument("pool: a value or its sd is no number");
  return std::max(0.0, value.sd * value.sd - common_sd * common_sd);
}

/// Exact values: equal to rounding, or refused.
Pooled pool_exact(std::span<const Estimate> exact, double common_sd) {
  Pooled pooled;
  pooled.count = exact.size();
  pooled.mean = {exact.front().value, common_sd};
  for (const Estimate& e : exact)
    if (std::abs(e.value - pooled.mean.value) > 1e-12 * std::abs(pooled.mean.value)) {
      pooled.chi2 = std::numeric_limits<double>::infinity();
      pooled.p_value = 0;
    }
  return pooled;
}

}  // namespace

Pooled pool(std::span<const Estimate> values, double common_sd) {
  if (values.empty()) throw std::invalid_argument("pool: no value");
  std::vector<double> variances;
  std::vector<Estimate> exact;
  for (const Estimate& value : values) {
    variances.push_back(own_variance(value, common_sd));
    if (variances.back() == 0) exact.push_back(value);
  }
  if (!exact.empty()) return pool_exact(exact, common_sd);

  double weights = 0, sum = 0;
  for (std::size_t k = 0; k < values.size(); ++k) {
    weights += 1 / variances[k];
    sum += values[k].value / variances[k];
  }
  Pooled pooled;
  pooled.count = values.size();
  pooled.mean.value = sum / weights;
  pooled.own_sd = std::sqrt(1 / weights);
  for (std::size_t k = 0; k < values.size(); ++k)
    pooled.chi2 += std::pow(values[k].value - pooled.mean.value, 2) / variances[k];
  const double dof = static_cast<double>(values.size()) - 1;
  pooled.p_value = internal::chi2_survival(pooled.chi2, dof);
  if (!pooled.one_value()) pooled.own_sd *= std::sqrt(pooled.chi2 / dof);
  pooled.mean.sd = std::hypot(pooled.own_sd, common_sd);
  return pooled;
}

Pooled pool_angles(std::span<const Estimate> values, double common_sd) {
  if (values.empty()) throw std::invalid_argument("pool: no value");
  const double first = values.front().value;
  std::vector<Estimate> differences;
  for (const Estimate& angle : values)
    differences.push_back({std::remainder(angle.value - first, 2 * std::numbers::pi), angle.sd});
  Pooled pooled = pool(differences, common_sd);
  pooled.mean.value += first;
  return pooled;
}

Estimate combined(const Estimate& first, const Estimate& second) {
  if (!(first.sd > 0)) return first;
  if (!(second.sd > 0)) return second;
  const double a = 1 / (first.sd * first.sd), b = 1 / (second.sd * second.sd);
  return {(a * first.value + b * second.value) / (a + b), 1 / std::sqrt(a + b)};
}

void take_in(Eigen::VectorXd& values, Eigen::MatrixXd& covariance, Eigen::Index i, const Estimate& seen) {
  const Eigen::VectorXd column = covariance.col(i);
  const Eigen::VectorXd gain = column / (column(i) + seen.sd * seen.sd);
  values += gain * (seen.value - values(i));
  covariance -= gain * column.transpose();
}

}  // namespace tribotrack::fit
