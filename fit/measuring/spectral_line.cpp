#include "fit/measuring/spectral_line.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numeric>

#include "fit/measuring/sine_fit.h"
#include "fit/tools/angles.h"
#include "fit/tools/dense.h"
#include "fit/tools/statistics.h"

namespace tribotrack::fit::internal {
namespace {

constexpr std::size_t kMostPoints = 2048;
constexpr long kFewestCycles = 3, kEnoughCycles = 5;
constexpr double kShare = 0.5;        ///< of what moves faster than w/2, in the line
constexpr double kAboveNoise = 20;    ///< of a bin's mean power: by chance in 1e-16 of the bins
constexpr double kLeftBySine = 0.05;  ///< of the squares that a cubic leaves, where cycles are few

/// Two columns to a polynomial's four, of time in units of half the span.
Eigen::MatrixXd columns_of(const Series& series, int degree, double w) {
  const auto n = static_cast<Eigen::Index>(series.size());
  Eigen::MatrixXd a(n, degree + 1 + (w > 0 ? 2 : 0));
  const double middle = 0.5 * (series.time.front() + series.time.back());
  for (Eigen::Index i = 0; i < n; ++i) {
    const double t = series.time[static_cast<std::size_t>(i)] - middle, x = 2 * t / series.span();
    a(i, 0) = 1;
    for (int k = 1; k <= degree; ++k) a(i, k) = a(i, k - 1) * x;
    if (w > 0) a.row(i).tail<2>() << std::cos(w * t), std::sin(w * t);
  }
  return a;
}

struct Fitted {
  Eigen::MatrixX2d coefficients, residuals;
};

Fitted fitted(const Series& series, int degree, double w = 0) {
  const Eigen::MatrixXd a = columns_of(series, degree, w);
  Eigen::MatrixX2d b(a.rows(), 2);
  for (Eigen::Index i = 0; i < a.rows(); ++i)
    b.row(i) = series.position[static_cast<std::size_t>(i)].transpose();
  Fitted fit{Eigen::MatrixX2d(a.cols(), 2), {}};
  for (int axis = 0; axis < 2; ++axis) fit.coefficients.col(axis) = least_squares(a, b.col(axis));
  fit.residuals = b - a * fit.coefficients;
  return fit;
}

/// Power at k cycles a span, k = 0 .. n/2, both axes together, of a cubic's residuals under Hann's window:
/// its side lobes fall fast enough that slow motion stays below what a drive shows.
std::vector<double> spectrum_of(const Series& series) {
  const Eigen::MatrixX2d residuals = fitted(series, 3).residuals;
  const std::size_t n = series.size();
  std::vector<std::complex<double>> step(n), turned(n, 1.0), x(n), y(n);
  for (std::size_t i = 0; i < n; ++i) {
    const double share = (series.time[i] - series.time.front()) / series.span();
    const double window = std::pow(std::sin(pi * share), 2);
    const auto row = static_cast<Eigen::Index>(i);
    step[i] = std::polar(1.0, turn * share);
    x[i] = window * residuals(row, 0);
    y[i] = window * residuals(row, 1);
  }
  std::vector<double> power;
  for (std::size_t k = 0; k <= n / 2; ++k) {
    std::complex<double> sum_x = 0, sum_y = 0;
    for (std::size_t i = 0; i < n; ++i) {
      sum_x += x[i] * turned[i];
      sum_y += y[i] * turned[i];
      turned[i] *= step[i];
    }
    power.push_back(std::norm(sum_x) + std::norm(sum_y));
  }
  return power;
}

double squares(const Fitted& fit) {
  return fit.residuals.squaredNorm();
}

/// Cycles a span of the strongest line; 0 where there is none.
double strongest_line(const Series& series) {
  constexpr double kMedianOfMean = 0.84;  // of a chi^2 of four degrees of freedom
  const std::vector<double> power = spectrum_of(series);
  const long count = static_cast<long>(power.size());
  const double floor = upper_median({power.begin() + count / 2, power.end()}) / kMedianOfMean;
  std::vector<double> beyond(power.size() + 1, 0.0);  // what all bins from here on hold above noise
  for (long k = count - 1; k >= 0; --k) {
    const auto at = static_cast<std::size_t>(k);
    beyond[at] = beyond[at + 1] + std::max(0.0, power[at] - floor);
  }
  const auto within = [&](long first, long last) {  // bins [first, last)
    return beyond[static_cast<std::size_t>(first)] - beyond[static_cast<std::size_t>(std::min(last, count))];
  };
  long best = 0;
  for (long k = kFewestCycles; k < count; ++k) {
    const auto at = static_cast<std::size_t>(k);
    if (!(power[at] > kAboveNoise * floor) ||
        (best > 0 && power[at] <= power[static_cast<std::size_t>(best)]))
      continue;
    const long half_width = std::max(1L, k / 8);  // a motion that decays has a wide line
    if (within(k - half_width, k + half_width + 1) < kShare * within(std::min(k - half_width, k / 2), count))
      continue;
    if (k < kEnoughCycles) {
      double left = squares(fitted(series, 3));
      const double all = left;
      for (double cycles = static_cast<double>(k) - 0.6; cycles <= static_cast<double>(k) + 0.6;
           cycles += 0.1)
        left = std::min(left, squares(fitted(series, 3, turn * cycles / series.span())));
      if (left > kLeftBySine * all) continue;
    }
    best = k;
  }
  return static_cast<double>(best);
}

struct Ellipse {
  double major = 0, minor = 0;
};

/// Of the sinusoid at w beside a parabola.
Ellipse ellipse_of(const Series& series, double w) {
  const Eigen::Matrix2d c = fitted(series, 2, w).coefficients.bottomRows<2>();
  const double sum = c.squaredNorm(), area = std::abs(c(0, 0) * c(1, 1) - c(0, 1) * c(1, 0));
  const double root = std::sqrt(std::max(0.0, sum * sum - 4 * area * area));
  return {std::sqrt(0.5 * (sum + root)), std::sqrt(std::max(0.0, 0.5 * (sum - root)))};
}

/// About the frequency of `cycles` in `seen`, from all points of the track.
Oscillation described(const TrackTable& track, const Series& seen, double cycles) {
  TrackTable all;
  all.time = track.time;
  all.marker = track.position;
  for (const Eigen::Matrix2d& covariance : track.covariance)
    all.marker_sigma.push_back(std::sqrt(0.5 * covariance.trace()));
  const MarkerSeries points(all);
  const SineFit sine = fit_sine(points, turn * cycles / seen.span());
  const SineResiduals residuals = analyse_residuals(points, sine, 1);
  const double n = static_cast<double>(track.time.size());
  const double wider = std::max({1.0, sine.chi2 / std::max(1.0, 2 * n - 9), residuals.near_w});

  Oscillation found;
  found.angular_frequency = {sine.w, std::sqrt(wider * sine.covariance(8, 8))};
  found.cycles = sine.w * points.span() / turn;
  const Ellipse whole = ellipse_of(seen, sine.w);
  found.major = whole.major;
  found.minor = whole.minor;
  const auto third = static_cast<std::ptrdiff_t>(seen.size() / 3);
  const auto part = [&](std::ptrdiff_t first) {
    return Series{{seen.time.begin() + first, seen.time.begin() + first + third},
                  {seen.position.begin() + first, seen.position.begin() + first + third}};
  };
  if (found.cycles >= kFewestCycles && third > 8) {
    const double first = ellipse_of(part(0), sine.w).major;
    const double last = ellipse_of(part(static_cast<std::ptrdiff_t>(seen.size()) - third), sine.w).major;
    if (first > 0) found.last_over_first = last / first;
  }
  found.drift = sine.coefficients.row(1).norm() * points.span();
  return found;
}

}  // namespace

Series thinned(const TrackTable& track, std::size_t first, std::size_t last, std::size_t most) {
  Series series;
  const std::size_t together = (last - first + most - 1) / most;
  for (std::size_t row = first; row + together <= last; row += together) {
    double time = 0;
    Eigen::Vector2d position = Eigen::Vector2d::Zero();
    for (std::size_t i = row; i < row + together; ++i) {
      time += track.time[i] / static_cast<double>(together);
      position += track.position[i] / static_cast<double>(together);
    }
    series.time.push_back(time);
    series.position.push_back(position);
  }
  return series;
}

std::optional<Oscillation> find_oscillation(const TrackTable& track) {
  constexpr std::size_t kFewestPoints = 16;
  const std::size_t n = track.time.size();
  if (n < kFewestPoints) return std::nullopt;
  const Series whole = thinned(track, 0, n, kMostPoints);
  if (const double cycles = strongest_line(whole); cycles > 0) return described(track, whole, cycles);
  if (n <= kMostPoints) return std::nullopt;
  const std::size_t first = (n - kMostPoints) / 2;
  const Series middle = thinned(track, first, first + kMostPoints, kMostPoints);
  if (const double cycles = strongest_line(middle); cycles > 0) return described(track, middle, cycles);
  return std::nullopt;
}

}  // namespace tribotrack::fit::internal
