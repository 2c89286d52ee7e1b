#include "fit/slides/incline.h"

#include "fit/residuals/free_slide.h"

namespace tribotrack::fit::internal {

Stretch sliding_stretch(const TrackTable& track) {
  const std::vector<double> speeds = smoothed_speeds(track);
  const Motion motion = find_motion(speeds);
  if (speeds.empty() || !motion.gains_speed()) return {0, track.time.size()};
  // Of points: a window's speed is that of its middle, and all of the fastest window slides.
  return {motion.first + kSpeedWindow, motion.fastest + 2 * kSpeedWindow + 1};
}

Eigen::Vector2d downhill_of(const TrajectoryRun& run) {
  const Eigen::Vector2d way = run.track.position.back() - run.track.position.front();
  const double length = way.norm();
  if (!(length > 0)) throw DataError("Free slide '" + run.name + "': the part does not move.");
  return run.slope > 0 ? Eigen::Vector2d(way / length) : Eigen::Vector2d(-way / length);
}

}  // namespace tribotrack::fit::internal
