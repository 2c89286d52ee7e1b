#include "fit/measuring/sine_residuals.h"
#include "fit/tools/angles.h"
#include "fit/tools/dense.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

namespace tribotrack::fit::internal {
namespace {

constexpr int kLowestRepeating = 4;  ///< below it the drive's own eccentricity may be seen
constexpr int kHighest = 12;

/// Residuals r = m - fit, both axes.
std::vector<Eigen::Vector2d> residuals_of(const MarkerSeries& marker, const SineFit& fit) {
  std::vector<Eigen::Vector2d> residuals;
  residuals.reserve(marker.size());
  for (std::size_t i = 0; i < marker.size(); ++i)
    residuals.emplace_back(marker.at(i) - fit.at(marker.time(i)));
  return residuals;
}

/// Mean periodogram power at 14 frequencies beside w, as a multiple of that of white noise of the weights'
/// sigma.
double power_near(const MarkerSeries& marker, const std::vector<Eigen::Vector2d>& residuals, double w) {
  const double bin = 2 * pi / marker.span();
  double total_weight = 0;
  for (std::size_t i = 0; i < marker.size(); ++i) total_weight += marker.weight(i);
  double sum = 0;
  int count = 0;
  for (int offset = -8; offset <= 8; ++offset) {
    const double frequency = w + offset * bin;
    if (std::abs(offset) < 2 || frequency < 2 * bin) continue;
    std::complex<double> x = 0, y = 0;
    for (std::size_t i = 0; i < marker.size(); ++i) {
      const std::complex<double> wave = std::polar(marker.weight(i), frequency * marker.time(i));
      x += wave * residuals[i].x();
      y += wave * residuals[i].y();
    }
    sum += (std::norm(x) + std::norm(y)) / total_weight;
    count += 2;
  }
  return count > 0 ? sum / count : 1;
}

/// Columns: 1, t, then cos(kwt), sin(kwt) for k = 1 .. highest.
Eigen::VectorXd columns(double t, double w, int highest) {
  Eigen::VectorXd c(2 + 2 * highest);
  c.head<2>() << 1, t;
  for (int k = 1; k <= highest; ++k) c.segment<2>(2 * k) << std::cos(k * w * t), std::sin(k * w * t);
  return c;
}

struct Linear {
  Eigen::VectorXd value;
  Eigen::MatrixXd covariance;  ///< for noise of the weights' sigma
};

Linear solved(const Eigen::MatrixXd& normal, const Eigen::VectorXd& right) {
  const Eigen::VectorXd scale = normal.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd scaled = scale.asDiagonal() * normal * scale.asDiagonal();
  const Eigen::VectorXd scaled_right = scale.asDiagonal() * right;
  return {scale.asDiagonal() * solve_symmetric(scaled, scaled_right),
          scale.asDiagonal() * inverse_symmetric(scaled) * scale.asDiagonal()};
}

/// The residuals' own constant, drift and multiples of w, axis by axis.
Linear fit_multiples(const MarkerSeries& marker, const std::vector<Eigen::Vector2d>& residuals, double w,
                     int highest, int axis) {
  const Eigen::Index n = 2 + 2 * highest;
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(n, n);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(n);
  for (std::size_t i = 0; i < marker.size(); ++i) {
    const Eigen::VectorXd c = columns(marker.time(i), w, highest);
    normal.selfadjointView<Eigen::Lower>().rankUpdate(c, marker.weight(i));
    right += marker.weight(i) * residuals[i](axis) * c;
  }
  return solved(normal.selfadjointView<Eigen::Lower>(), right);
}

/// One Gauss-Newton step of the sine fit with the phase w t + q t^2 / 2: q.
Estimate fit_drift(const MarkerSeries& marker, const std::vector<Eigen::Vector2d>& residuals,
                   const SineFit& fit) {
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(10, 10);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(10);
  for (std::size_t i = 0; i < marker.size(); ++i) {
    const double t = marker.time(i);
    const double c = std::cos(fit.w * t), s = std::sin(fit.w * t);
    for (int axis = 0; axis < 2; ++axis) {
      const auto k = fit.coefficients.col(axis);
      const double by_phase = k(3) * c - k(2) * s;
      Eigen::VectorXd row = Eigen::VectorXd::Zero(10);
      row.segment<4>(4 * axis) << 1, t, c, s;
      row(8) = t * by_phase;
      row(9) = 0.5 * t * t * by_phase;
      normal += marker.weight(i) * row * row.transpose();
      right += marker.weight(i) * residuals[i](axis) * row;
    }
  }
  const Linear solution = solved(normal, right);
  return {solution.value(9), std::sqrt(solution.covariance(9, 9))};
}

Estimate amplitude_of(const Linear& solution, int order, double variance_factor, double repeating) {
  const Eigen::Vector2d c = solution.value.segment<2>(2 * order);
  const double amplitude = c.norm();
  const Eigen::Vector2d along = amplitude > 0 ? Eigen::Vector2d(c / amplitude) : Eigen::Vector2d(1, 0);
  const double variance = along.dot(solution.covariance.block<2, 2>(2 * order, 2 * order) * along);
  return {amplitude, std::sqrt(variance_factor * variance + repeating)};
}

}  // namespace

SineResiduals analyse_residuals(const MarkerSeries& marker, const SineFit& fit, double noise_factor) {
  const auto residuals = residuals_of(marker, fit);
  SineResiduals result;
  const double cycles = marker.span() * fit.w / (2 * pi);
  if (marker.size() < 40 || cycles < 3) return result;
  result.near_w = power_near(marker, residuals, fit.w);
  const Estimate drift = fit_drift(marker, residuals, fit);
  result.frequency_drift = {drift.value, drift.sd * std::sqrt(noise_factor)};

  // Multiples up to a little below half the frame rate.
  const double frames_a_cycle = static_cast<double>(marker.size()) / cycles;
  const int highest = std::min(kHighest, static_cast<int>(0.45 * frames_a_cycle));
  if (highest < 2) return result;
  const Linear x = fit_multiples(marker, residuals, fit.w, highest, 0);
  const Linear y = fit_multiples(marker, residuals, fit.w, highest, 1);
  double excess = 0, count = 0;
  for (int k = kLowestRepeating; k <= highest; ++k)
    for (const Linear* axis : {&x, &y})
      for (int part = 2 * k; part < 2 * k + 2; ++part) {
        excess += axis->value(part) * axis->value(part) - noise_factor * axis->covariance(part, part);
        ++count;
      }
  if (count > 0) result.repeating_variance = std::max(0.0, excess / count);
  for (int order = 2; order <= std::min(3, highest); ++order)
    result.harmonics.push_back({order, amplitude_of(x, order, noise_factor, result.repeating_variance),
                                amplitude_of(y, order, noise_factor, result.repeating_variance)});
  return result;
}

}  // namespace tribotrack::fit::internal
