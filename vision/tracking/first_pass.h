// The first pass: the part, the marker and the lamp followed frame by frame, each by its own template.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "vision/frame_source.h"
#include "vision/picture.h"
#include "vision/platform_motion/motion.h"
#include "vision/stages/stages.h"
#include "vision/tracking/setup.h"

namespace tribotrack::vision {

/// Mean grey level of the pixels whose centres lie in a circle, frame by frame. The lamp does not move, so
/// every pixel of the circle sees a fixed share of it and the mean is linear in the light: lit for a share s
/// of an exposure it lies at off + s (on - off), whatever the circle's fit to the lamp. Only pixels that clip
/// break this; they are counted.
class GateLamp {
 public:
  /// Throws InputError where the circle is not wholly in the picture.
  GateLamp(const Circle& circle, const FrameSource& source);

  struct Sample {
    double level = 0;          ///< grey levels
    double clipped_share = 0;  ///< share of the pixels at the top level
  };
  Sample sample(FrameSource& source, std::int64_t index);

  int pixels() const { return cv::countNonZero(mask_); }

 private:
  Rect window_;
  double top_;
  cv::Mat mask_;     ///< of the circle in the window
  Picture picture_;  ///< work space
};

class FirstPass {
 public:
  /// Keeps references; the summary is filled as things become known. The range begins where the part is first
  /// seen. Throws InputError where it, the marker or the lamp cannot be followed from there.
  FirstPass(FrameSource& source, const FrameRange& range, const Appearance& seen, const Camera& camera,
            const TrackOptions& options, StageClock& clock, TrackSummary& summary);

  /// Of the part in the first frame.
  const std::optional<DiscFit>& rim() const { return setup_.rim; }

  /// The next frame; they must come in order. Where the part was seen, if it was: it may still turn out not
  /// to be the part.
  std::optional<Point> step(std::int64_t index);

  /// The round mark as it was seen in the last frame.
  std::optional<Circle> mark() const;

  /// After the last frame. Follows the platform's ground where that serves as the marker.
  Track finish();

  /// Complete after finish().
  const FirstPassResult& result() const { return setup_.result; }
  /// To TrackOptions::debug: template, weights, and in each of these frames window, prediction and residual.
  void show(const Track& track, const ShownFrames& frames);

 private:
  FollowStep follow_part(std::int64_t index);
  void follow_marker(std::int64_t index, TrackPoint& point);
  void sample_lamp(std::int64_t index, TrackPoint& point);
  void glance_at_ground(std::int64_t index, const FollowStep& step);
  void follow_ground();

  FrameSource& source_;
  const TrackOptions& options_;
  StageClock& clock_;
  TrackSummary& summary_;
  Picture first_;
  PartSetup setup_;
  PatternFollower part_;
  std::optional<PatternFollower> marker_;
  std::optional<GroundSampler> glance_;  ///< at the ground: does it move?
  Point last_seen_;                      ///< the part
  std::optional<GateLamp> lamp_;

  Track track_;
  std::optional<Sighting> tentative_;  ///< in the last frame, to be confirmed by the next
  std::vector<double> excess_;
  std::int64_t refound_ = 0;
  std::vector<std::size_t> came_back_;  ///< points at which a part that had left was found again
};

}  // namespace tribotrack::vision
