#include "fit/residuals/free_slide.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace tribotrack::fit::internal {
namespace {

constexpr std::size_t kHalfWindow = 3;
constexpr std::size_t kFewest = 8;

/// Slope of a straight line through the points [first, last).
Eigen::Vector2d slope(const TrackTable& track, std::size_t first, std::size_t last) {
  const double count = static_cast<double>(last - first);
  double time = 0, square = 0;
  Eigen::Vector2d position = Eigen::Vector2d::Zero(), product = Eigen::Vector2d::Zero();
  for (std::size_t i = first; i < last; ++i) {
    time += track.time[i] / count;
    position += track.position[i] / count;
  }
  for (std::size_t i = first; i < last; ++i) {
    square += (track.time[i] - time) * (track.time[i] - time);
    product += (track.time[i] - time) * (track.position[i] - position);
  }
  return product / square;
}

}  // namespace

FreeSlideGuess guess_free_slide(const TrajectoryRun& run) {
  const TrackTable& track = run.track;
  const std::size_t n = track.time.size();
  const auto refuse = [&](const std::string& why) -> void {
    throw DataError("Free slide '" + run.name + "': " + why);
  };
  if (n < kFewest)
    refuse("only " + std::to_string(n) + " tracked points; at least " + std::to_string(kFewest) +
           " are needed: check frames and the track's lost rows.");

  std::size_t fastest = kHalfWindow;
  double top = -1;
  for (std::size_t i = kHalfWindow; i + kHalfWindow < n; ++i) {
    const double speed = slope(track, i - kHalfWindow, i + kHalfWindow + 1).norm();
    if (speed > top) {
      top = speed;
      fastest = i;
    }
  }
  FreeSlideGuess guess;
  guess.first = fastest == kHalfWindow ? 0 : fastest;
  guess.last = n;
  // The frame of the strike itself lies between rest and sliding: its step is short.
  const auto step_speed = [&](std::size_t i) {
    return (track.position[i + 1] - track.position[i]).norm() / (track.time[i + 1] - track.time[i]);
  };
  while (guess.first < fastest && step_speed(guess.first) < 0.9 * top) ++guess.first;
  if (guess.last - guess.first < kFewest)
    refuse("the part is fastest at the end of the track, so no free sliding was seen: analyse later frames.");
  if (!(top > 0)) refuse("the part does not move.");

  // Until the speed has fallen to a tenth: a straight line for the speed gives mu.
  std::vector<double> times, speeds;
  for (std::size_t i = guess.first + kHalfWindow; i + kHalfWindow < n; ++i) {
    const double speed = slope(track, i - kHalfWindow, i + kHalfWindow + 1).norm();
    if (speed < 0.1 * top && times.size() >= 2) break;
    times.push_back(track.time[i]);
    speeds.push_back(speed);
  }
  double mean_time = 0, mean_speed = 0, square = 0, product = 0;
  for (std::size_t i = 0; i < times.size(); ++i) {
    mean_time += times[i] / static_cast<double>(times.size());
    mean_speed += speeds[i] / static_cast<double>(times.size());
  }
  for (std::size_t i = 0; i < times.size(); ++i) {
    square += (times[i] - mean_time) * (times[i] - mean_time);
    product += (times[i] - mean_time) * (speeds[i] - mean_speed);
  }
  const double deceleration = square > 0 ? -product / square : 0;
  const double gravity = run.scenario.drive.gravity;
  guess.mu = deceleration > 0 ? deceleration / gravity : 0.01 * top * top / gravity;
  guess.mu = std::max(guess.mu, 1e-4);
  const std::size_t window_end = std::min(n, guess.first + 2 * kHalfWindow + 1);
  const Eigen::Vector2d early = slope(track, guess.first, window_end);
  const double middle = 0.5 * (track.time[window_end - 1] - track.time[guess.first]);
  const double speed = early.norm() + guess.mu * gravity * middle;
  guess.velocity = early.norm() > 0 ? Eigen::Vector2d(early.normalized() * speed) : early;
  return guess;
}

}  // namespace tribotrack::fit::internal
