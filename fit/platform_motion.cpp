// The platform's circle from the marker: eq. (1) by least squares with w free (variable projection), started
// from a periodogram.
#include <Eigen/Cholesky>
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "fit/measurement.h"
#include "model/displacement_angle.h"

namespace tribotrack::fit {
namespace {

constexpr double pi = std::numbers::pi;

/// Per axis: offset, drift, cosine, sine; then w. Times from the middle, so that offset and drift decouple.
struct SineFit {
  Eigen::Matrix<double, 4, 2> coefficients = Eigen::Matrix<double, 4, 2>::Zero();
  double w = 0;
  double chi2 = 0;
  double residual_square = 0;                                                    ///< sum over both axes, m^2
  Eigen::Matrix<double, 9, 9> covariance = Eigen::Matrix<double, 9, 9>::Zero();  ///< x4, y4, w
};

class Marker {
 public:
  explicit Marker(const TrackTable& track) : track_(track) {
    middle_ = 0.5 * (track.time.front() + track.time.back());
  }
  std::size_t size() const { return track_.marker.size(); }
  double time(std::size_t i) const { return track_.time[i] - middle_; }
  double middle() const { return middle_; }
  const Eigen::Vector2d& at(std::size_t i) const { return track_.marker[i]; }
  double weight(std::size_t i) const {  ///< 1/variance
    const double sigma = i < track_.marker_sigma.size() ? track_.marker_sigma[i] : 0;
    return sigma > 0 && std::isfinite(sigma) ? 1 / (sigma * sigma) : 1;
  }
  bool has_sigma() const {
    return track_.marker_sigma.size() == size() &&
           std::all_of(track_.marker_sigma.begin(), track_.marker_sigma.end(),
                       [](double s) { return s > 0 && std::isfinite(s); });
  }

 private:
  const TrackTable& track_;
  double middle_;
};

Eigen::Vector4d basis(double t, double w) {
  return {1, t, std::cos(w * t), std::sin(w * t)};
}

/// The linear part at known w over the frames [first, last).
void solve_linear(const Marker& marker, std::size_t first, std::size_t last, SineFit& fit) {
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
double step(const Marker& marker, std::size_t first, std::size_t last, SineFit& fit) {
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

void refine(const Marker& marker, std::size_t first, std::size_t last, SineFit& fit) {
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
double strongest_frequency(const Marker& marker, std::size_t first, std::size_t last) {
  const double span = marker.time(last - 1) - marker.time(first);
  std::vector<double> gaps;
  for (std::size_t i = first + 1; i < last; ++i) gaps.push_back(marker.time(i) - marker.time(i - 1));
  std::nth_element(gaps.begin(), gaps.begin() + gaps.size() / 2, gaps.end());
  const double top = pi / gaps[gaps.size() / 2];

  // Offset and drift off first.
  SineFit line;
  Eigen::Matrix2d normal = Eigen::Matrix2d::Zero(), right = Eigen::Matrix2d::Zero();
  for (std::size_t i = first; i < last; ++i) {
    const Eigen::Vector2d b(1, marker.time(i));
    normal += b * b.transpose();
    right += b * marker.at(i).transpose();
  }
  const Eigen::Matrix2d coefficients = normal.ldlt().solve(right);
  std::vector<Eigen::Vector2d> detrended;
  for (std::size_t i = first; i < last; ++i)
    detrended.push_back(marker.at(i) - coefficients.transpose() * Eigen::Vector2d(1, marker.time(i)));

  const double spacing = 0.5 * pi / span;  // four to a line's width
  double best_power = -1, best = 0;
  std::vector<std::complex<double>> turn, turned;
  for (std::size_t i = first; i < last; ++i) turn.push_back(std::polar(1.0, spacing * marker.time(i)));
  const long count = static_cast<long>(top / spacing);
  const long lowest = 6;  // 1.5 cycles a span: slower is drift
  for (std::size_t i = first; i < last; ++i)
    turned.push_back(std::polar(1.0, static_cast<double>(lowest) * spacing * marker.time(i)));
  for (long k = lowest; k <= count; ++k) {
    std::complex<double> x = 0, y = 0;
    for (std::size_t i = 0; i < turned.size(); ++i) {
      x += detrended[i].x() * turned[i];
      y += detrended[i].y() * turned[i];
      turned[i] *= turn[i];
    }
    const double power = std::norm(x) + std::norm(y);
    if (power > best_power) {
      best_power = power;
      best = static_cast<double>(k) * spacing;
    }
  }
  return best;
}

/// Amplitude and phase p of a cos(wt) + b sin(wt) = A cos(wt + p), with p moved to time zero.
struct Wave {
  Estimate amplitude, phase;
  Eigen::Matrix<double, 9, 1> phase_row = Eigen::Matrix<double, 9, 1>::Zero();
};

Wave wave(const SineFit& fit, int axis, double middle) {
  const double a = fit.coefficients(2, axis), b = fit.coefficients(3, axis);
  const double amplitude = std::hypot(a, b);
  Wave result;
  Eigen::Matrix<double, 9, 1> amplitude_row = Eigen::Matrix<double, 9, 1>::Zero();
  if (amplitude > 0) {
    amplitude_row.segment<2>(4 * axis + 2) << a / amplitude, b / amplitude;
    result.phase_row.segment<2>(4 * axis + 2) << b / (amplitude * amplitude), -a / (amplitude * amplitude);
  }
  result.phase_row(8) = -middle;
  result.amplitude = {amplitude, std::sqrt(amplitude_row.dot(fit.covariance * amplitude_row))};
  result.phase = {std::atan2(-b, a) - fit.w * middle,
                  std::sqrt(result.phase_row.dot(fit.covariance * result.phase_row))};
  return result;
}

double into_circle(double angle) {
  const double turned = std::fmod(angle, 2 * pi);
  const double positive = turned < 0 ? turned + 2 * pi : turned;
  return positive >= 2 * pi ? 0 : positive;
}

}  // namespace

std::optional<PlatformMotion> measure_platform_motion(const TrackTable& track) {
  if (track.marker.empty()) return std::nullopt;
  if (track.marker.size() != track.time.size())
    throw DataError("The track has a marker in some rows only; track the recording again.");
  constexpr std::size_t fewest = 12;
  if (track.time.size() < fewest) return std::nullopt;

  const Marker marker(track);
  // A block in the middle finds w, growing blocks keep it: no cycle can slip.
  const std::size_t n = marker.size();
  std::size_t block = std::min<std::size_t>(n, 1024);
  const auto window = [&] { return std::pair((n - block) / 2, (n - block) / 2 + block); };
  SineFit fit;
  fit.w = strongest_frequency(marker, window().first, window().second);
  if (!(fit.w > 0)) return std::nullopt;
  for (;; block = std::min(n, 2 * block)) {
    refine(marker, window().first, window().second, fit);
    if (block == n) break;
  }

  const double freedom = 2.0 * static_cast<double>(n) - 9;
  const double excess = fit.chi2 / freedom;
  fit.covariance *= marker.has_sigma() ? std::max(1.0, excess) : excess;
  const Wave x = wave(fit, 0, marker.middle()), y = wave(fit, 1, marker.middle());

  // At rest: the sine is below the noise it sits in.
  const double mean_square = fit.residual_square / (2.0 * static_cast<double>(n));
  const double signal =
      0.25 * (x.amplitude.value * x.amplitude.value + y.amplitude.value * y.amplitude.value);
  double noise = mean_square;
  if (marker.has_sigma()) {
    double own = 0;
    for (const double sigma : track.marker_sigma) own += sigma * sigma;
    noise = std::max(noise, own / static_cast<double>(n));
  }
  if (!(signal > noise)) return std::nullopt;

  PlatformMotion motion;
  motion.amplitude = x.amplitude;
  motion.amplitude_y = y.amplitude;
  motion.angular_frequency = {fit.w, std::sqrt(fit.covariance(8, 8))};
  motion.residual_rms = std::sqrt(mean_square);
  const bool moves_x = x.amplitude.value > 3 * x.amplitude.sd;
  const bool moves_y = y.amplitude.value > 3 * y.amplitude.sd;
  // Motion along one axis only leaves epsilon open; 0 is written with the sd of an unknown angle.
  const Wave& leading = moves_x ? x : y;
  motion.phase_at_zero = {into_circle(leading.phase.value), leading.phase.sd};
  if (moves_x && moves_y) {
    const Eigen::Matrix<double, 9, 1> row = y.phase_row - x.phase_row;
    motion.phase_shift = {model::wrap_angle(y.phase.value - x.phase.value),
                          std::sqrt(row.dot(fit.covariance * row))};
    motion.clockwise = std::sin(motion.phase_shift.value) > 0;
  } else {
    motion.phase_shift = {0, pi / std::sqrt(3.0)};
  }
  return motion;
}

}  // namespace tribotrack::fit
