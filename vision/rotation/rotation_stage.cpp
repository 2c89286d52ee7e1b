#include "vision/rotation/rotation_stage.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "vision/rotation/rotation_track.h"

namespace tribotrack::vision {
namespace {

using std::numbers::pi;

/// Each angle by whole turns nearest to what the two before let expect.
class Unwrapped {
 public:
  double next(std::int64_t frame, double theta) {
    const double expected = last_ + rate_ * static_cast<double>(frame - frame_);
    theta += 2 * pi * std::round((expected - theta) / (2 * pi));
    if (any_) rate_ = (theta - last_) / static_cast<double>(frame - frame_);
    any_ = true;
    last_ = theta;
    frame_ = frame;
    return theta;
  }

 private:
  bool any_ = false;
  double last_ = 0, rate_ = 0;
  std::int64_t frame_ = 0;
};

void take_template(const FirstPassResult& first, Track& track) {
  Unwrapped unwrapped;
  std::optional<double> origin;
  for (std::size_t k = 0; k < track.points.size(); ++k) {
    TrackPoint& p = track.points[k];
    if (p.status != TrackStatus::ok || !(first.sigma_theta[k] > 0)) continue;
    const double theta = unwrapped.next(p.frame, first.theta[k]);
    if (!origin) origin = theta;
    p.rotation = Rotation{theta - *origin, first.sigma_theta[k]};
  }
  track.has_rotation = origin.has_value();
}

PlanStage by_rings(FrameSource& source, const FirstPassResult& first, Track& track, int threads) {
  PlanStage stage{.name = "rotation by rings", .reason = "its texture is not seen again in most frames"};
  std::vector<PlacedFrame> frames;
  std::vector<std::size_t> places;
  for (std::size_t k = 0; k < track.points.size(); ++k)
    if (track.points[k].status == TrackStatus::ok) {
      frames.push_back(
          {first.first_index + static_cast<std::int64_t>(k), {track.points[k].x, track.points[k].y}});
      places.push_back(k);
    }
  const auto seen = follow_rotation(source, frames, first.disc.radius, first.blur, threads);
  double low = 0, high = 0;
  std::size_t count = 0;
  for (std::size_t k = 0; k < seen.size(); ++k) {
    if (!seen[k]) continue;
    track.points[places[k]].rotation = seen[k];
    low = std::min(low, seen[k]->theta);
    high = std::max(high, seen[k]->theta);
    ++count;
  }
  track.has_rotation = stage.on = count > 0;
  if (stage.on)
    stage.reason = fmt::format(
        "{} frames compared ring by ring with a picture learnt on the way; the part turns through {:.3g} rad",
        count, high - low);
  return stage;
}

}  // namespace

void measure_rotation(FrameSource& source, const FirstPassResult& first, Track& track,
                      std::vector<PlanStage>& plan, int threads) {
  if (!first.texture_seen) return;
  if (first.disc.radius > 0)
    plan.push_back(by_rings(source, first, track, threads));
  else if (first.turning)
    take_template(first, track);
}

}  // namespace tribotrack::vision
