#include "vision/layers/model/rim.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace tribotrack::vision {
namespace {
constexpr double kPriorSd = 0.1;
}

RimProfile::RimProfile(double radius, double blur) {
  const double reach = std::clamp(4 * blur, 3.0, std::max(3.0, 0.5 * radius));
  inner_ = std::max(0.0, radius - reach);
  outer_ = radius + reach;
  const auto knots = static_cast<std::size_t>(std::ceil((outer_ - inner_) / 0.5)) + 1;
  step_ = (outer_ - inner_) / static_cast<double>(knots - 1);
  for (std::size_t k = 0; k < knots; ++k) {
    const double rho = inner_ + step_ * static_cast<double>(k);
    value_.push_back(1 - 0.5 * std::erfc((rho - radius) / (std::numbers::sqrt2 * blur)));
  }
  value_.front() = 0;
  value_.back() = 1;
  right_.assign(knots, 0);
  diagonal_.assign(knots, 0);
  beside_.assign(knots, 0);
}

RimProfile::Place RimProfile::place(double rho) const {
  const double t = (rho - inner_) / step_;
  const auto knot = std::min(static_cast<std::size_t>(std::max(0.0, t)), value_.size() - 2);
  return {knot, t - static_cast<double>(knot)};
}

double RimProfile::at(double rho) const {
  if (rho <= inner_) return 0;
  if (rho >= outer_) return 1;
  const Place p = place(rho);
  return (1 - p.fraction) * value_[p.knot] + p.fraction * value_[p.knot + 1];
}

void RimProfile::add(double rho, double covariance, double variance) {
  if (rho <= inner_ || rho >= outer_) return;
  const Place p = place(rho);
  const double f = p.fraction;
  right_[p.knot] += (1 - f) * covariance;
  right_[p.knot + 1] += f * covariance;
  diagonal_[p.knot] += (1 - f) * (1 - f) * variance;
  diagonal_[p.knot + 1] += f * f * variance;
  beside_[p.knot] += f * (1 - f) * variance;
}

void RimProfile::solve(double noise_variance) {
  const auto n = static_cast<Eigen::Index>(value_.size());
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(n, n);
  Eigen::VectorXd right(n);
  const double prior = noise_variance / (kPriorSd * kPriorSd);
  for (Eigen::Index k = 0; k < n; ++k) {
    const auto i = static_cast<std::size_t>(k);
    normal(k, k) = diagonal_[i] + prior;
    right(k) = right_[i] + prior * value_[i];
    if (k + 1 < n) normal(k, k + 1) = normal(k + 1, k) = beside_[i];
  }
  // The ends are 0 and 1 by definition.
  for (const Eigen::Index end : {Eigen::Index{0}, n - 1}) {
    const double value = end == 0 ? 0 : 1;
    right -= value * normal.col(end);
    normal.row(end).setZero();
    normal.col(end).setZero();
    normal(end, end) = 1;
    right(end) = value;
  }
  const Eigen::VectorXd solution = normal.ldlt().solve(right);
  if (solution.allFinite())
    for (Eigen::Index k = 0; k < n; ++k) value_[static_cast<std::size_t>(k)] = solution(k);
  for (auto* v : {&right_, &diagonal_, &beside_}) std::fill(v->begin(), v->end(), 0.0);
}

}  // namespace tribotrack::vision
