#include "fit/motion.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <complex>
#include <numeric>
#include <vector>

#include "fit/measuring/sine_fit.h"
#include "fit/problem.h"
#include "fit/residuals/free_slide.h"
#include "fit/slides/blows.h"
#include "fit/slides/one_by_one.h"
#include "fit/tools/angles.h"
#include "fit/tools/dense.h"
#include "fit/tools/statistics.h"
#include "fit/tools/track_errors.h"

namespace tribotrack::fit {
namespace {

using namespace internal;

/// Points in the order of time, some of a track or means of several that follow each other.
struct Series {
  std::vector<double> time;
  std::vector<Eigen::Vector2d> position;
  std::size_t size() const { return time.size(); }
  double span() const { return time.back() - time.front(); }
};

// The line in the spectrum of a track's positions that stands for a motion that repeats.

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

/// Major and minor semi-axis of the sinusoid at w beside a parabola.
Eigen::Vector2d axes_of(const Series& series, double w) {
  return singular_values(fitted(series, 2, w).coefficients.bottomRows<2>()).values;
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
  const Eigen::Vector2d whole = axes_of(seen, sine.w);
  found.major = whole(0);
  found.minor = whole(1);
  const auto third = static_cast<std::ptrdiff_t>(seen.size() / 3);
  const auto part = [&](std::ptrdiff_t first) {
    return Series{{seen.time.begin() + first, seen.time.begin() + first + third},
                  {seen.position.begin() + first, seen.position.begin() + first + third}};
  };
  if (found.cycles >= kFewestCycles && third > 8) {
    const double first = axes_of(part(0), sine.w)(0);
    const double last = axes_of(part(static_cast<std::ptrdiff_t>(seen.size()) - third), sine.w)(0);
    if (first > 0) found.last_over_first = last / first;
  }
  found.drift = sine.coefficients.row(1).norm() * points.span();
  return found;
}

/// Means of as many points as leave no more than `most`, of the rows [first, last).
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

/// As fit/motion.h says what a line is. Looked for in means over the whole track, then in the points of its
/// middle, whose cycles those means may hide.
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

constexpr std::size_t kFewest = 8;
constexpr double kRests = 10;  ///< sd of a point: a shorter way tells nothing
/// An ellipse as round as this is a circle that a platform makes; a pendulum's plane keeps.
constexpr double kRound = 0.3;
constexpr double kDecays = 0.7;        ///< of its first amplitude in the last third
constexpr double kMovesOn = 3;         ///< amplitudes
constexpr double kSteady = 2.0 / 3;    ///< q: halves of the braking differ by a factor of two
constexpr double kUnexplained = 0.01;  ///< of the squares that a straight line leaves
constexpr double kBySurprise = 1e-4;   ///< that a straight line would be left so by chance
constexpr double kOneWay = 0.8;        ///< of its path leads away from where it began
/// Of the whole path, at the least: of a slide, which a hand may begin and end; of an incline, which none
/// pulls.
constexpr double kOfSlide = 0.25, kOfIncline = 0.7;

/// What a point errs by when `together` of them are averaged.
struct Noise {
  double white = 0, slow = 0;  ///< m per axis
  double of_mean(double together) const { return std::sqrt(white * white / together + slow * slow); }
};

Noise noise_of(const TrackTable& track) {
  const double slow = slow_variance(track, 0), variance = mean_variance(track);
  return {std::sqrt(std::max(0.0, variance - slow)), std::sqrt(std::min(slow, variance))};
}

/// Least squares of p0 + v g over the points; g of their times.
struct AlongShape {
  Eigen::Vector2d velocity = Eigen::Vector2d::Zero();
  double squares = 0;
};

AlongShape along(const Series& series, const std::vector<double>& shape) {
  const auto line = line_through<Eigen::Vector2d>(shape, series.position);
  AlongShape fit{line.slope, 0};
  for (std::size_t i = 0; i < series.size(); ++i)
    fit.squares += (series.position[i] - line.at(shape[i])).squaredNorm();
  return fit;
}

std::vector<double> shape_of(const Series& series, double stop, double q) {
  std::vector<double> shape;
  for (const double time : series.time) {
    const double x = std::min((time - series.time.front()) / stop, 1.0);
    shape.push_back(stop * (x - x * x / 2 - q * (x * x / 2 - x * x * x / 3)));
  }
  return shape;
}

/// Does the velocity of these points fall evenly to 0, or towards it?
std::optional<EvenBraking> braking_of(const Series& series, const Noise& noise, double together) {
  if (series.size() < kFewest) return std::nullopt;
  const double span = series.span(), degrees = 2 * static_cast<double>(series.size()) - 5;
  const double line = along(series, shape_of(series, 1e6 * span, 0)).squares;
  AlongShape best;
  double least = line, stop = 0, shape = 0;
  for (double logarithm = std::log(0.1); logarithm < std::log(20.0); logarithm += 0.04)
    for (int step = -5; step <= 5; ++step) {
      const double at = span * std::exp(logarithm), q = kSteady * step / 5;
      const AlongShape fit = along(series, shape_of(series, at, q));
      if (fit.squares >= least) continue;
      best = fit, least = fit.squares, stop = at, shape = q;
    }
  if (!(stop > 0)) return std::nullopt;
  // Slow errors leave fewer independent values than there are points.
  std::vector<double> left;
  const std::vector<double> g = shape_of(series, stop, shape);
  for (std::size_t i = 0; i < series.size(); ++i)
    left.push_back(best.velocity.normalized().dot(series.position[i] - g[i] * best.velocity));
  const double mean = std::accumulate(left.begin(), left.end(), 0.0) / static_cast<double>(left.size());
  for (double& l : left) l -= mean;
  const double independent = degrees / residual_correlation_time(left, 4);
  if (chi2_survival((line - least) / least * independent, 2) > kBySurprise) return std::nullopt;
  const double by_noise = degrees * std::pow(noise.of_mean(together), 2);
  if (std::max(0.0, least - by_noise) / std::max(line - by_noise, 1e-300) > kUnexplained) return std::nullopt;
  EvenBraking found;
  found.speed = best.velocity.norm();
  const double seen = std::min(1.0, span / stop);
  found.deceleration = found.speed / stop * (1 + shape * (1 - seen));
  return found;
}

/// Means of the rows [first, last), in which the part may be braked; `backwards`: read from the end.
std::optional<EvenBraking> braking_in(const TrackTable& track, std::size_t first, std::size_t last,
                                      bool backwards) {
  constexpr std::size_t kMost = 300;
  if (last < first + kFewest) return std::nullopt;
  Series series = thinned(track, first, last, kMost);
  if (backwards) {
    std::ranges::reverse(series.position);
    std::ranges::reverse(series.time);
    for (double& time : series.time) time = -time;
  }
  const double together = static_cast<double>(last - first) / static_cast<double>(series.size());
  auto found = braking_of(series, noise_of(track), together);
  if (!found) return std::nullopt;
  found->first = first;
  found->last = last;
  if (backwards) found->deceleration = -found->deceleration;
  return found;
}

/// How far the part goes and comes in the rows [first, last), but for noise.
double path(const TrackTable& track, std::size_t first, std::size_t last) {
  const Series coarse = thinned(track, first, last, 24);
  double length = 0;
  for (std::size_t i = 1; i < coarse.size(); ++i)
    length += (coarse.position[i] - coarse.position[i - 1]).norm();
  return length;
}

/// The braking, where it makes up that share of the path.
std::optional<EvenBraking> if_most(const TrackTable& track, std::optional<EvenBraking> found, double share) {
  if (found && path(track, found->first, found->last) < share * path(track, 0, track.time.size()))
    found.reset();
  return found;
}

/// In the stretch and from the point on that the fit of a slide takes.
std::optional<EvenBraking> slide_in(const TrackTable& track) {
  const internal::Stretch clean = longest_clean_stretch(track, find_blows(track));
  TrajectoryRun run;
  run.track = part_of(track, clean.first, clean.last);
  try {
    const FreeSlideGuess guess = guess_free_slide(run);
    return if_most(track, braking_in(track, clean.first + guess.first, clean.last, false), kOfSlide);
  } catch (const DataError&) {  // nothing is left in which it could slide
    return std::nullopt;
  }
}

std::optional<EvenBraking> incline_in(const TrackTable& track) {
  const internal::Stretch gaining = sliding_stretch(track);
  return if_most(track, braking_in(track, gaining.first, std::min(gaining.last, track.time.size()), true),
                 kOfIncline);
}

bool goes_one_way(const TrackTable& track) {
  const Series coarse = thinned(track, 0, track.time.size(), 24);
  const double away = (coarse.position.back() - coarse.position.front()).norm();
  return away > kOneWay * path(track, 0, track.time.size());
}

/// Vibration of the camera, or of what it stands on: so little of the way that the part slides all the same.
bool vibrates_only(const Oscillation& o, const ShownMotion& shown, const TrackTable& track) {
  constexpr double kOfWay = 0.01;
  constexpr std::size_t kMost = 600;  // blows are looked for at every point
  if (shown.way <= kRests * shown.noise) return o.major < shown.noise;
  if (o.major > kOfWay * shown.way) return false;
  const Series means = thinned(track, 0, track.time.size(), kMost);
  TrackTable coarse;
  coarse.time = means.time;
  coarse.position = means.position;
  coarse.covariance.assign(means.size(), shown.noise * shown.noise * Eigen::Matrix2d::Identity());
  return slide_in(coarse).has_value();
}

MotionKind kind_of(const Oscillation& o) {
  if (o.last_over_first < kDecays) return MotionKind::swinging;
  const bool round = o.minor > kRound * o.major, moves_on = o.drift > kMovesOn * o.major;
  return round || moves_on ? MotionKind::driven : MotionKind::swinging;
}

}  // namespace

const char* to_string(MotionKind kind) {
  constexpr const char* kNames[] = {"unknown",       "at rest", "driven", "swinging",
                                    "slide to rest", "incline", "pulled", "with background"};
  return kNames[static_cast<std::size_t>(kind)];
}

ShownMotion shown_motion(const TrackTable& track) {
  ShownMotion shown;
  const std::size_t n = track.time.size();
  if (n < kFewest) return shown;
  shown.noise = noise_of(track).of_mean(1);
  for (const Eigen::Vector2d& p : track.position)
    shown.way = std::max(shown.way, (p - track.position.front()).norm());
  shown.speed = shown.way / (track.time.back() - track.time.front());
  shown.oscillation = find_oscillation(track);
  if (shown.oscillation && vibrates_only(*shown.oscillation, shown, track)) shown.oscillation.reset();
  if (shown.oscillation) {
    shown.kind = kind_of(*shown.oscillation);
  } else if (shown.way <= kRests * shown.noise) {
    shown.kind = MotionKind::at_rest;
  } else if ((shown.braking = slide_in(track))) {
    shown.kind = MotionKind::slide;
  } else if ((shown.braking = incline_in(track))) {
    shown.kind = MotionKind::incline;
  } else if (goes_one_way(track)) {
    shown.kind = MotionKind::pulled;
  }
  return shown;
}

}  // namespace tribotrack::fit
