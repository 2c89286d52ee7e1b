#include "fit/motion.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "fit/measuring/spectral_line.h"
#include "fit/problem.h"
#include "fit/residuals/free_slide.h"
#include "fit/slides/blows.h"
#include "fit/slides/one_by_one.h"
#include "fit/tools/statistics.h"
#include "fit/tools/track_errors.h"

namespace tribotrack::fit {
namespace {

using namespace internal;

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
  const double slow = slow_variance(track, 0);
  double variance = 0;
  for (const Eigen::Matrix2d& covariance : track.covariance)
    variance += 0.5 * covariance.trace() / static_cast<double>(track.covariance.size());
  return {std::sqrt(std::max(0.0, variance - slow)), std::sqrt(std::min(slow, variance))};
}

/// Least squares of p0 + v g over the points; g of their times.
struct AlongShape {
  Eigen::Vector2d velocity = Eigen::Vector2d::Zero();
  double squares = 0;
};

AlongShape along(const Series& series, const std::vector<double>& shape) {
  const double n = static_cast<double>(series.size());
  double mean = 0, square = 0;
  Eigen::Vector2d middle = Eigen::Vector2d::Zero(), product = Eigen::Vector2d::Zero();
  for (std::size_t i = 0; i < series.size(); ++i) {
    mean += shape[i] / n;
    middle += series.position[i] / n;
  }
  for (std::size_t i = 0; i < series.size(); ++i) {
    square += (shape[i] - mean) * (shape[i] - mean);
    product += (shape[i] - mean) * (series.position[i] - middle);
  }
  AlongShape fit;
  if (square > 0) fit.velocity = product / square;
  for (std::size_t i = 0; i < series.size(); ++i)
    fit.squares += (series.position[i] - middle - (shape[i] - mean) * fit.velocity).squaredNorm();
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
  const double mean = [&] {
    double sum = 0;
    for (const double l : left) sum += l;
    return sum / static_cast<double>(left.size());
  }();
  for (double& l : left) l -= mean;
  const double independent = degrees / residual_correlation_time(left, 4);
  if (chi2_survival((line - least) / least * independent, 2) > kBySurprise) return std::nullopt;
  const double by_noise = degrees * std::pow(noise.of_mean(together), 2);
  EvenBraking found;
  found.unexplained = std::max(0.0, least - by_noise) / std::max(line - by_noise, 1e-300);
  if (found.unexplained > kUnexplained) return std::nullopt;
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
    return if_most(track, braking_in(track, clean.first + guess.first, clean.first + guess.last, false),
                   kOfSlide);
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
