#include "fit/measuring/sine_fit.h"

#include <algorithm>
#include <cmath>
#include <complex>

#include "fit/tools/angles.h"
#include "fit/tools/dense.h"
#include "fit/tools/statistics.h"

namespace tribotrack::fit::internal {
namespace {

Eigen::Vector4d basis(double t, double w) {
  return {1, t, std::cos(w * t), std::sin(w * t)};
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

struct Step {
  Linear change;
  double chi2 = 0, residual_square = 0;  ///< before it
};

/// One Gauss-Newton step over the frames [first, last): on the eight coefficients, which are linear; with w;
/// or on ten numbers, with the phase w t + q t^2 / 2, q the last.
template <int N>
Step step(const MarkerSeries& marker, std::size_t first, std::size_t last, const SineFit& fit) {
  Step result;
  Eigen::Matrix<double, N, N> normal = Eigen::Matrix<double, N, N>::Zero();
  Eigen::Matrix<double, N, 1> right = Eigen::Matrix<double, N, 1>::Zero();
  for (std::size_t i = first; i < last; ++i) {
    const double t = marker.time(i);
    const Eigen::Vector4d b = basis(t, fit.w);
    for (int axis = 0; axis < 2; ++axis) {
      const auto c = fit.coefficients.col(axis);
      const double residual = marker.at(i)(axis) - b.dot(c), by_phase = c(3) * b(2) - c(2) * b(3);
      Eigen::Matrix<double, N, 1> row = Eigen::Matrix<double, N, 1>::Zero();
      row.template segment<4>(4 * axis) = b;
      if constexpr (N > 8) row(8) = t * by_phase;
      if constexpr (N > 9) row(9) = 0.5 * t * t * by_phase;
      normal += marker.weight(i) * row * row.transpose();
      right += marker.weight(i) * residual * row;
      result.chi2 += marker.weight(i) * residual * residual;
      result.residual_square += residual * residual;
    }
  }
  result.change = solved(normal, right);
  return result;
}

void solve_linear(const MarkerSeries& marker, std::size_t first, std::size_t last, SineFit& fit) {
  fit.coefficients.reshaped() += step<8>(marker, first, last, fit).change.value;
}

void refine(const MarkerSeries& marker, std::size_t first, std::size_t last, SineFit& fit) {
  solve_linear(marker, first, last, fit);
  const double resolution = pi / std::max(1e-300, marker.time(last - 1) - marker.time(first));
  for (int i = 0; i < 30; ++i) {
    const double change = step<9>(marker, first, last, fit).change.value(8);
    fit.w += std::clamp(change, -0.5 * resolution, 0.5 * resolution);
    solve_linear(marker, first, last, fit);
    if (std::abs(change) < 1e-14 * fit.w) break;
  }
  const Step left = step<9>(marker, first, last, fit);
  fit.chi2 = left.chi2;
  fit.residual_square = left.residual_square;
  fit.covariance = left.change.covariance;
}

/// w of the strongest line between two cycles a span and Nyquist's frequency, both axes together.
double strongest_frequency(const MarkerSeries& marker, std::size_t first, std::size_t last) {
  const double span = marker.time(last - 1) - marker.time(first);
  std::vector<double> gaps, times;
  std::vector<Eigen::Vector2d> places;
  for (std::size_t i = first; i < last; ++i) {
    if (i > first) gaps.push_back(marker.time(i) - marker.time(i - 1));
    times.push_back(marker.time(i));
    places.push_back(marker.at(i));
  }
  const double top = pi / upper_median(gaps);
  const auto drift = line_through<Eigen::Vector2d>(times, places);
  double size = 1e-300;  // metres squared would leave the range of single precision
  for (std::size_t i = first; i < last; ++i) size = std::max(size, marker.at(i).cwiseAbs().maxCoeff());
  // Single precision tells which line is the strongest; its frequency is refined later.
  const auto n = static_cast<Eigen::Index>(last - first);
  const auto time = Eigen::Map<const Eigen::ArrayXd>(times.data(), n);
  Eigen::VectorXf x(n), y(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::Vector2d detrended = places[static_cast<std::size_t>(i)] - drift.at(time(i));
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

SineFit fit_sine(const MarkerSeries& marker, double start) {
  const std::size_t n = marker.size();
  std::size_t block = std::min<std::size_t>(n, 1024);
  const auto window = [&] { return std::pair((n - block) / 2, (n - block) / 2 + block); };
  SineFit fit;
  fit.w = start > 0 ? start : strongest_frequency(marker, window().first, window().second);
  if (!(fit.w > 0)) return fit;
  for (;; block = std::min(n, 2 * block)) {
    refine(marker, window().first, window().second, fit);
    if (block == n) return fit;
  }
}

std::optional<MotionBreak> break_of(const MarkerSeries& marker, const SineFit& fit) {
  constexpr std::size_t kAside = 6;              ///< frames on either side
  constexpr double kMost = 0.7, kChance = 1e-6;  ///< a slow wander looks like a step, too, but leaves more
  const std::size_t n = marker.size();
  Eigen::Matrix3d own = Eigen::Matrix3d::Zero();
  Eigen::Matrix<double, 3, 9> with_fit = Eigen::Matrix<double, 3, 9>::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  std::optional<MotionBreak> found;
  double most = kMost * fit.chi2;
  for (std::size_t i = n; i-- > kAside;) {
    const double t = marker.time(i), weight = marker.weight(i);
    const Eigen::Vector4d b = basis(t, fit.w);
    for (int axis = 0; axis < 2; ++axis) {
      const auto c = fit.coefficients.col(axis);
      const double by_phase = c(3) * b(2) - c(2) * b(3);
      Eigen::Matrix<double, 9, 1> row = Eigen::Matrix<double, 9, 1>::Zero();
      row.segment<4>(4 * axis) = b;
      row(8) = t * by_phase;
      const Eigen::Vector3d moved(axis == 0, axis == 1, fit.w * by_phase);
      own += weight * moved * moved.transpose();
      with_fit += weight * moved * row.transpose();
      right += weight * (marker.at(i)(axis) - b.dot(c)) * moved;
    }
    if (n - i < kAside) continue;
    const Eigen::Matrix3d left = own - with_fit * fit.covariance * with_fit.transpose();
    const Linear change = solved(left, right);
    const double gain = right.dot(change.value);
    if (!(gain > most) || !(left.diagonal().array() > 1e-6 * own.diagonal().array()).all()) continue;
    most = gain;
    found = {i, change.value.head<2>(), change.value(2)};
  }
  const double dof = 2.0 * static_cast<double>(n) - 12;
  if (!found || dof < 1) return std::nullopt;
  const double chance = chi2_survival(most / ((fit.chi2 - most) / dof), 3, dof);
  return static_cast<double>(n) * chance < kChance ? found : std::nullopt;
}

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
  const Linear drift = step<10>(marker, 0, marker.size(), fit).change;
  result.frequency_drift = {drift.value(9), std::sqrt(noise_factor * drift.covariance(9, 9))};

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
