#include "fit/residuals/free_slide.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "fit/tools/statistics.h"

namespace tribotrack::fit::internal {
namespace {

constexpr std::size_t kFewest = 8;

/// Velocity over the points [first, last).
Eigen::Vector2d velocity(const TrackTable& track, std::size_t first, std::size_t last) {
  return line_through<Eigen::Vector2d>(std::span(track.time).subspan(first, last - first),
                                       std::span(track.position).subspan(first, last - first))
      .slope;
}

/// Deceleration of a part of mu = 0, and that of mu = 1 beyond it.
struct Braking {
  double by_slope, by_friction;
};
Braking braking(const TrajectoryRun& run) {
  const double gravity = run.scenario.drive.gravity;
  return {-gravity * std::sin(run.slope), gravity * std::cos(run.slope)};
}

}  // namespace

std::vector<double> smoothed_speeds(const TrackTable& track) {
  std::vector<double> speeds;
  for (std::size_t i = kSpeedWindow; i + kSpeedWindow < track.time.size(); ++i)
    speeds.push_back(velocity(track, i - kSpeedWindow, i + kSpeedWindow + 1).norm());
  return speeds;
}

Motion find_motion(const std::vector<double>& speeds) {
  Motion motion;
  if (speeds.empty()) return motion;
  motion.fastest = static_cast<std::size_t>(std::max_element(speeds.begin(), speeds.end()) - speeds.begin());
  const double slow = kStillSlow * speeds[motion.fastest];
  motion.first = motion.last = motion.fastest;
  while (motion.first > 0 && speeds[motion.first - 1] >= slow) --motion.first;
  while (motion.last + 1 < speeds.size() && speeds[motion.last + 1] >= slow) ++motion.last;
  return motion;
}

FreeSlideGuess guess_free_slide(const TrajectoryRun& run) {
  const TrackTable& track = run.track;
  const std::size_t n = track.time.size();
  const auto refuse = [&](const std::string& why) -> void {
    throw DataError("Free slide '" + run.name + "': " + why);
  };
  if (n < kFewest)
    refuse("only " + std::to_string(n) + " tracked points; at least " + std::to_string(kFewest) +
           " are needed: check frames and the track's lost rows.");

  const std::vector<double> speed = smoothed_speeds(track);
  const Motion motion = find_motion(speed);
  const std::size_t place = motion.fastest, fastest = place + kSpeedWindow;
  const double top = speed[place];
  if (!(top > 0)) refuse("the part does not move.");
  FreeSlideGuess guess;
  const bool gains_speed = run.slope != 0 && motion.gains_speed();
  guess.first = place == 0 || gains_speed ? 0 : fastest;
  // The frame of the strike itself lies between rest and sliding: its step is short.
  const auto step_speed = [&](std::size_t i) {
    return (track.position[i + 1] - track.position[i]).norm() / (track.time[i + 1] - track.time[i]);
  };
  while (!gains_speed && guess.first < fastest && step_speed(guess.first) < 0.9 * top) ++guess.first;
  if (n - guess.first < kFewest)
    refuse(
        "the part is fastest at the end of the track, so no free sliding was seen: analyse later frames, or "
        "give slope_rad if it slides down an incline.");

  // Until the speed has fallen to a tenth: a straight line for the speed gives mu.
  std::vector<double> times, speeds;
  for (std::size_t i = guess.first + kSpeedWindow; i + kSpeedWindow < n; ++i) {
    const double here = speed[i - kSpeedWindow];
    if (!gains_speed && here < 0.1 * top && times.size() >= 2) break;
    times.push_back(track.time[i]);
    speeds.push_back(here);
  }
  const Braking by = braking(run);
  guess.mu = (-line_through<double>(times, speeds).slope - by.by_slope) / by.by_friction;
  if (!(guess.mu > 0)) guess.mu = 0.01 * top * top / by.by_friction;
  guess.mu = std::max(guess.mu, 1e-4);
  const std::size_t window_end = std::min(n, guess.first + 2 * kSpeedWindow + 1);
  const Eigen::Vector2d early = velocity(track, guess.first, window_end);
  const double middle = 0.5 * (track.time[window_end - 1] - track.time[guess.first]);
  const double first_speed = early.norm() + (by.by_slope + guess.mu * by.by_friction) * middle;
  guess.velocity =
      early.norm() > 0 ? Eigen::Vector2d(early.normalized() * std::max(first_speed, 0.0)) : early;
  return guess;
}

}  // namespace tribotrack::fit::internal
