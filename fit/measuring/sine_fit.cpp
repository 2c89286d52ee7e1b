#include "fit/measuring/sine_fit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "fit/tools/angles.h"
#include "fit/tools/statistics.h"

namespace tribotrack::fit::internal {
namespace {

Eigen::Vector4d basis(double t, double w) {
  return {1, t, std::cos(w * t), std::sin(w * t)};
}

/// The linear part at known w over the frames [first, last).
void solve_linear(const MarkerSeries& marker, std::size_t first, std::size_t last, SineFit& fit) {
  Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
  Eigen::Matrix<double, 4, 2> right = Eigen::Matrix<double, 4, 2>::Zero();
  for (std::size_t i = first; i < last; ++i) {
    const Eigen::Vector4d b = basis(marker.time(i), fit.w);
    normal += marker.weight(i) * b * b.transpose();
    right += marker.weight(i) * b * marker.at(i).transpose();
  }
  const Eigen::Vector4d scale = normal.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::Matrix4d scaled = scale.asDiagonal() * normal * scale.asDiagonal();
  fit.coefficients = scale.asDiagonal() * scaled.ldlt().solve((scale.asDiagonal() * right).eval());
}

/// One Gauss-Newton step on all nine numbers; returns the step in w.
double step(const MarkerSeries& marker, std::size_t first, std::size_t last, SineFit& fit) {
  Eigen::Matrix<double, 9, 9> normal = Eigen::Matrix<double, 9, 9>::Zero();
  Eigen::Matrix<double, 9, 1> right = Eigen::Matrix<double, 9, 1>::Zero();
  fit.chi2 = fit.residual_square = 0;
  for (std::size_t i = first; i < last; ++i) {
    const double t = marker.time(i);
    const Eigen::Vector4d b = basis(t, fit.w);
    for (int axis = 0; axis < 2; ++axis) {
      const auto c = fit.coefficients.col(axis);
      const double residual = marker.at(i)(axis) - b.dot(c);
      Eigen::Matrix<double, 9, 1> row = Eigen::Matrix<double, 9, 1>::Zero();
      row.segment<4>(4 * axis) = b;
      row(8) = t * (c(3) * b(2) - c(2) * b(3));
      normal += marker.weight(i) * row * row.transpose();
      right += marker.weight(i) * residual * row;
      fit.chi2 += marker.weight(i) * residual * residual;
      fit.residual_square += residual * residual;
    }
  }
  const Eigen::Matrix<double, 9, 1> scale = normal.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Eigen::Matrix<double, 9, 9> scaled = scale.asDiagonal() * normal * scale.asDiagonal();
  const Eigen::LDLT<Eigen::Matrix<double, 9, 9>> factor(scaled);
  const Eigen::Matrix<double, 9, 1> scaled_right = scale.asDiagonal() * right;
  const Eigen::Matrix<double, 9, 1> change = scale.asDiagonal() * factor.solve(scaled_right);
  fit.covariance =
      scale.asDiagonal() * factor.solve(Eigen::Matrix<double, 9, 9>::Identity()) * scale.asDiagonal();
  return change(8);
}

void refine(const MarkerSeries& marker, std::size_t first, std::size_t last, SineFit& fit) {
  solve_linear(marker, first, last, fit);
  const double resolution = pi / std::max(1e-300, marker.time(last - 1) - marker.time(first));
  for (int i = 0; i < 30; ++i) {
    const double change = step(marker, first, last, fit);
    fit.w += std::clamp(change, -0.5 * resolution, 0.5 * resolution);
    solve_linear(marker, first, last, fit);
    if (std::abs(change) < 1e-14 * fit.w) break;
  }
  step(marker, first, last, fit);
}

/// w of the strongest line between two cycles a span and Nyquist's frequency, both axes together.
double strongest_frequency(const MarkerSeries& marker, std::size_t first, std::size_t last) {
  const double span = marker.time(last - 1) - marker.time(first);
  std::vector<double> gaps;
  for (std::size_t i = first + 1; i < last; ++i) gaps.push_back(marker.time(i) - marker.time(i - 1));
  const double top = pi / upper_median(gaps);

  // Offset and drift off first.
  Eigen::Matrix2d normal = Eigen::Matrix2d::Zero(), right = Eigen::Matrix2d::Zero();
  for (std::size_t i = first; i < last; ++i) {
    const Eigen::Vector2d b(1, marker.time(i));
    normal += b * b.transpose();
    right += b * marker.at(i).transpose();
  }
  const Eigen::Matrix2d coefficients = normal.ldlt().solve(right);
  double size = 1e-300;  // metres squared would leave the range of single precision
  for (std::size_t i = first; i < last; ++i) size = std::max(size, marker.at(i).cwiseAbs().maxCoeff());
  // Single precision tells which line is the strongest; its frequency is refined later.
  const auto n = static_cast<Eigen::Index>(last - first);
  Eigen::ArrayXd time(n);
  Eigen::VectorXf x(n), y(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const std::size_t at = first + static_cast<std::size_t>(i);
    time(i) = marker.time(at);
    const Eigen::Vector2d detrended = marker.at(at) - coefficients.transpose() * Eigen::Vector2d(1, time(i));
    x(i) = static_cast<float>(detrended.x() / size);
    y(i) = static_cast<float>(detrended.y() / size);
  }

  const double spacing = 0.5 * pi / span;  // four to a line's width
  const long count = static_cast<long>(top / spacing);
  const long lowest = 6;  // 1.5 cycles a span: slower is drift
  // cos and sin of k spacing t, turned on from k to k + 1.
  const auto first_cos = [&](double k) -> Eigen::VectorXf {
    return (k * spacing * time).cos().cast<float>();
  };
  const auto first_sin = [&](double k) -> Eigen::VectorXf {
    return (k * spacing * time).sin().cast<float>();
  };
  const Eigen::ArrayXf step_cos = first_cos(1), step_sin = first_sin(1);
  Eigen::VectorXf cos = first_cos(lowest), sin = first_sin(lowest), turned(n);
  float best_power = -1;
  long best = 0;
  for (long k = lowest; k <= count; ++k) {
    const Eigen::Vector4f sums(x.dot(cos), x.dot(sin), y.dot(cos), y.dot(sin));
    if (const float power = sums.squaredNorm(); power > best_power) {
      best_power = power;
      best = k;
    }
    turned = cos.array() * step_cos - sin.array() * step_sin;
    sin = sin.array() * step_cos + cos.array() * step_sin;
    cos.swap(turned);
  }
  return static_cast<double>(best) * spacing;
}

}  // namespace

double MarkerSeries::weight(std::size_t i) const {
  const double sigma = i < track_.marker_sigma.size() ? track_.marker_sigma[i] : 0;
  return sigma > 0 && std::isfinite(sigma) ? 1 / (sigma * sigma) : 1;
}

bool MarkerSeries::has_sigma() const {
  return track_.marker_sigma.size() == size() &&
         std::all_of(track_.marker_sigma.begin(), track_.marker_sigma.end(),
                     [](double s) { return s > 0 && std::isfinite(s); });
}

Eigen::Vector2d SineFit::at(double t) const {
  return coefficients.transpose() * basis(t, w);
}

SineFit fit_sine(const MarkerSeries& marker) {
  const std::size_t n = marker.size();
  std::size_t block = std::min<std::size_t>(n, 1024);
  const auto window = [&] { return std::pair((n - block) / 2, (n - block) / 2 + block); };
  SineFit fit;
  fit.w = strongest_frequency(marker, window().first, window().second);
  if (!(fit.w > 0)) return fit;
  for (;; block = std::min(n, 2 * block)) {
    refine(marker, window().first, window().second, fit);
    if (block == n) return fit;
  }
}

}  // namespace tribotrack::fit::internal
