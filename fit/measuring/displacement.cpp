#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <optional>
#include <vector>

#include "fit/measurement.h"
#include "fit/tools/angles.h"
#include "fit/tools/dense.h"
#include "fit/tools/track_errors.h"
#include "model/alpha_v.h"

namespace tribotrack::fit {
namespace {

using internal::covariance_of_sum;
using internal::WeightedPoints;

/// Value and slope at a time, as sums of points, of the polynomial through those nearest to it (Lagrange's
/// form: so their noise is known).
struct LocalPolynomial {
  WeightedPoints value, slope;
};

/// Through `points` neighbours of `time`, as many before as after where the track allows, but for `left_out`.
LocalPolynomial polynomial_at(const std::vector<double>& times, double time, std::size_t points,
                              std::optional<std::size_t> left_out = std::nullopt) {
  // Grow to both sides in turn; at the track's ends to the side that is left.
  std::size_t below =
      static_cast<std::size_t>(std::upper_bound(times.begin(), times.end(), time) - times.begin());
  std::size_t above = below;  // [below, above) is taken
  std::vector<std::size_t> taken;
  bool to_left = true;
  while (taken.size() < points && (below > 0 || above < times.size())) {
    const bool left = (to_left && below > 0) || above == times.size();
    const std::size_t next = left ? --below : above++;
    if (next == left_out) continue;
    taken.push_back(next);
    to_left = !left;
  }
  std::sort(taken.begin(), taken.end());
  LocalPolynomial polynomial;
  for (const std::size_t k : taken) {
    double weight = 1, slope = 0;
    for (const std::size_t j : taken) {
      if (j == k) continue;
      const double width = times[k] - times[j];
      slope = slope * (time - times[j]) / width + weight / width;
      weight *= (time - times[j]) / width;
    }
    polynomial.value.emplace_back(k, weight);
    polynomial.slope.emplace_back(k, slope);
  }
  return polynomial;
}

Eigen::Vector2d sum_of(const WeightedPoints& points, const std::vector<Eigen::Vector2d>& positions) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const auto& [point, weight] : points) sum += weight * positions[point];
  return sum;
}

void check(const TrackTable& track, const Estimate& w, int cycles) {
  const std::size_t points = track.time.size();
  if (track.position.size() != points || track.covariance.size() != points)
    throw DataError("The track's columns have different lengths; track the recording again.");
  if (!(w.value > 0) || !std::isfinite(w.value) || !(w.sd >= 0))
    throw DataError(fmt::format(
        "The angular frequency is {:g} rad/s; it must be positive: give angular_frequency_rad_s or track a "
        "marker.",
        w.value));
  if (cycles < 1) throw DataError("cycles = " + std::to_string(cycles) + "; at least 1 is needed.");
  for (std::size_t i = 1; i < points; ++i)
    if (!(track.time[i] > track.time[i - 1]))
      throw DataError("The track's times do not increase at row " + std::to_string(i + 1) +
                      "; check time_s in the track file.");
  for (std::size_t i = 0; i < points; ++i)
    if (!std::isfinite(track.time[i]) || !track.position[i].allFinite() || !track.covariance[i].allFinite())
      throw DataError("The track's row " + std::to_string(i + 1) + " holds a value that is not a number.");
}

/// Interior frames seen at about the platform phase of `time`, at least eight of them where there are so
/// many.
std::vector<std::size_t> frames_of_same_phase(const TrackTable& track, double time, double w, double window) {
  std::vector<std::pair<double, std::size_t>> by_distance;
  for (std::size_t i = 2; i + 2 < track.time.size(); ++i)
    by_distance.emplace_back(std::abs(model::wrap_angle(w * (track.time[i] - time))) / w, i);
  std::sort(by_distance.begin(), by_distance.end());
  std::vector<std::size_t> frames;
  for (const auto& [distance, i] : by_distance)
    if (distance <= window || frames.size() < 8) frames.push_back(i);
  return frames;
}

struct Interpolated {
  Eigen::Vector2d position, velocity;
  WeightedPoints points;          ///< whose sum the position is
  Eigen::Matrix2d interpolation;  ///< mean square error of interpolating
};

/// What interpolating between `left` and `right` costs at `time`: each frame of the same platform phase is
/// left out and predicted from its neighbours, as friction switches come back at the same phase. Where the
/// acceleration jumps, the error goes with the product of the distances to both neighbours.
struct LeaveOneOut {
  Eigen::Matrix2d mean_square = Eigen::Matrix2d::Zero();  ///< scaled to `time`, noise taken off
  double score = 0;                                       ///< mean square as it is, noise included
};

LeaveOneOut leave_one_out(const TrackTable& track, const std::vector<std::size_t>& frames, std::size_t points,
                          double product) {
  LeaveOneOut result;
  const auto count = static_cast<double>(frames.size());
  for (const std::size_t i : frames) {
    WeightedPoints off = polynomial_at(track.time, track.time[i], points, i).value;
    off.emplace_back(i, -1);
    const Eigen::Vector2d difference = sum_of(off, track.position);
    const Eigen::Matrix2d noise = covariance_of_sum(track, off);
    const double own_product = (track.time[i] - track.time[i - 1]) * (track.time[i + 1] - track.time[i]);
    const double factor = product / own_product;
    result.mean_square += factor * factor * (difference * difference.transpose() - noise);
    result.score += difference.squaredNorm() / count;
  }
  result.mean_square = internal::without_negative_eigenvalues(result.mean_square / count);
  return result;
}

Interpolated interpolate(const TrackTable& track, double time, double w, std::size_t left) {
  const double before = time - track.time[left];
  const double after = track.time[left + 1] - time;
  const auto frames = frames_of_same_phase(track, time, w, before + after);
  // Two, four or six points: whichever predicts the frames left out best.
  std::size_t best_points = std::min<std::size_t>(4, track.time.size());
  LeaveOneOut best;
  for (const std::size_t points : {2UL, 4UL, 6UL}) {
    if (track.time.size() < points + 1 || frames.empty()) continue;
    const LeaveOneOut tried = leave_one_out(track, frames, points, before * after);
    if (best.score > 0 && tried.score >= best.score) continue;
    best = tried;
    best_points = points;
  }
  const WeightedPoints here = polynomial_at(track.time, time, best_points).value;
  const LocalPolynomial four = polynomial_at(track.time, time, std::min<std::size_t>(4, track.time.size()));
  return {sum_of(here, track.position), sum_of(four.slope, track.position), here, best.mean_square};
}

[[noreturn]] void refuse_short(double span, double period, double w) {
  throw DataError(
      fmt::format("The track covers {:g} s, less than one platform cycle of {:g} s (w = {:g} rad/s): analyse "
                  "more frames, or "
                  "check frame_rate_hz and angular_frequency_rad_s.",
                  span, period, w));
}

}  // namespace

void derive_alpha_and_v(Displacement& displacement) {
  const Eigen::Vector2d& d = displacement.vector;
  const double length = d.norm();
  const double widest = std::sqrt(std::max(0.0, internal::eigenvalues(displacement.covariance)(1)));
  displacement.alpha.reset();
  if (length > 0) {
    const Eigen::Vector2d along = d / length;
    const Eigen::Vector2d across(-along.y(), along.x());
    displacement.mean_velocity = {
        length / displacement.duration,
        std::sqrt(std::max(0.0, along.dot(displacement.covariance * along))) / displacement.duration};
    if (length >= 3 * widest)
      displacement.alpha = {model::displacement_angle(d),
                            std::sqrt(std::max(0.0, across.dot(displacement.covariance * across))) / length};
  } else {
    displacement.mean_velocity = {0, widest / displacement.duration};
  }
}

Displacement displacement_from_alpha_v(const Estimate& alpha, const Estimate& velocity,
                                       double angular_frequency, int cycles) {
  if (!(angular_frequency > 0) || cycles < 1 || !(velocity.value >= 0) || !(velocity.sd > 0) ||
      !(alpha.sd > 0) || !std::isfinite(alpha.value) || !std::isfinite(velocity.value))
    throw DataError(
        "A run measured elsewhere needs a finite alpha_rad, v_mm_s >= 0, and alpha_sd_rad, v_sd_mm_s > 0.");
  Displacement result;
  result.given_as_velocity = true;
  result.cycles = cycles;
  result.duration = cycles * 2 * std::numbers::pi / angular_frequency;
  const double length = velocity.value * result.duration;
  const Eigen::Vector2d along(std::cos(alpha.value), std::sin(alpha.value));
  const Eigen::Vector2d across(-along.y(), along.x());
  const double sd_along = velocity.sd * result.duration;
  // At v = 0 the direction has no meaning: the vector is as uncertain across as along.
  const double sd_across = std::max(length * std::min(alpha.sd, 1.0), length > 0 ? 0.0 : sd_along);
  result.vector = length * along;
  result.covariance =
      sd_along * sd_along * along * along.transpose() + sd_across * sd_across * across * across.transpose();
  derive_alpha_and_v(result);
  return result;
}

Displacement measure_displacement(const TrackTable& track, const Estimate& angular_frequency, int cycles) {
  check(track, angular_frequency, cycles);
  const double w = angular_frequency.value;
  const double period = 2 * std::numbers::pi / w;
  if (track.time.size() < 3)
    refuse_short(track.time.empty() ? 0 : track.time.back() - track.time.front(), period, w);
  const double start = track.time.front();
  const double span = track.time.back() - start;
  const double rounding = 1e-6 * (track.time.back() - track.time[track.time.size() - 2]);
  int n = static_cast<int>(std::min<double>(cycles, std::floor((span + rounding) / period)));
  if (n < 1) refuse_short(span, period, w);

  // The end may fall into a gap of lost frames: then whole cycles are given up until it does not.
  std::size_t left = 0;
  double end = 0;
  for (; n >= 1; --n) {
    end = std::min(start + n * period, track.time.back());
    const auto next = std::upper_bound(track.time.begin(), track.time.end(), end);
    left = static_cast<std::size_t>(std::min<std::ptrdiff_t>(
        next - track.time.begin() - 1, static_cast<std::ptrdiff_t>(track.time.size()) - 2));
    if (track.time[left + 1] - track.time[left] <= period / 6 || end == track.time[left]) break;
  }
  if (n < 1)
    throw DataError(
        "No frame was tracked near the end of any whole cycle (gaps longer than a sixth of a cycle): record "
        "at "
        "more than 6 frames a cycle, or find out why the part was lost.");

  const Interpolated last = interpolate(track, end, w, left);
  Displacement result;
  result.cycles = n;
  result.duration = n * period;
  result.vector = last.position - track.position.front();
  // End time N 2 pi / w: d(end)/dw = -u T / w. In the camera's frame u holds the platform's velocity, too.
  const Eigen::Vector2d by_w = -last.velocity * result.duration / w;
  WeightedPoints both_ends = last.points;
  both_ends.emplace_back(0, -1);
  result.covariance = covariance_of_sum(track, both_ends) + last.interpolation;
  derive_alpha_and_v(result);
  const double sd_w = angular_frequency.sd;
  const double length = result.vector.norm();
  const double v_by_w =
      length > 0 ? result.vector.dot(by_w) / length / result.duration + length / result.duration / w
                 : by_w.norm() / result.duration;
  const double v_sd = std::hypot(result.mean_velocity.sd, v_by_w * sd_w);
  result.covariance += by_w * by_w.transpose() * sd_w * sd_w;
  derive_alpha_and_v(result);
  result.mean_velocity.sd = v_sd;
  return result;
}

SeenThroughPlay seen_through_play(double amplitude, double half_width) {
  using internal::pi;
  if (!(half_width > 0)) return {};
  const double r = amplitude > 0 ? half_width / amplitude : 1;
  if (r >= 1) return {1, pi / 2};
  const double a = (pi / 2 + std::asin(1 - 2 * r) + 2 * (1 - 2 * r) * std::sqrt(r * (1 - r))) / pi;
  const double b = 4 * r * (1 - r) / pi;
  return {1 - std::hypot(a, b), std::atan2(b, a)};
}

}  // namespace tribotrack::fit
