// The platform's motion from its ground, as much of it as is seen: no mark is needed.
//
//   GroundMotionOptions options;
//   options.noise_variance = camera.noise_variance;
//   options.hidden = [&](std::int64_t index) { return std::vector<Circle>{part_with_shadow(index)}; };
//   if (look_at_ground(sample_ground(source, first, last, kGroundGlance, options), noise_variance).moves)
//     const auto motion = follow_ground(source, first, last, options);
//
// The ground is learnt from frames spread over the recording (learning.h), and every frame registered to it
// (registration.h). How well the two directions are known differs where the ground is brushed: along the
// brush less than across. The covariance says it.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "vision/frame_source.h"
#include "vision/platform_motion/coarse_shift.h"
#include "vision/platform_motion/learning.h"

namespace tribotrack::vision {

struct GroundMotionOptions {
  double noise_variance = 1.0 / 12;  ///< of a pixel, grey levels^2: the least that is believed
  /// What lies over the ground in a frame: the part with its shadow, a lamp. Others that cross are trimmed.
  std::function<std::vector<Circle>(std::int64_t index)> hidden = [](std::int64_t) {
    return std::vector<Circle>{};
  };
};

/// Frames, pixels of each and rounds of the learning.
struct GroundEffort {
  int frames = 0;
  int pixels = 0;
  int rounds = 0;
};
/// To tell whether the ground moves: at the cost of some windows about the part.
inline constexpr GroundEffort kGroundGlance{12, 1 << 16, 2};
/// To follow it: frames whose noise adds less than a hundredth; pixels beyond which registering a frame would
/// take longer than reading it, while four times as many would halve the standard deviation; rounds that
/// mostly are not needed.
inline constexpr GroundEffort kGroundLearning{128, 1 << 18, 10};

struct GroundSample {
  Rect place;  ///< what is learnt of the ground
  std::vector<GroundFrame> frames;
};

/// Collects the sample: frames spread over first .. last, but not evenly (that could meet the same phase of a
/// vibration again and again), read whole, kept as far as they show it; fewer of large pictures.
class GroundSampler {
 public:
  GroundSampler(const Picture& first_picture, const std::vector<Circle>& hidden, std::int64_t first,
                std::int64_t last, const GroundEffort& effort, double noise_variance);
  bool wants(std::int64_t index) const;
  /// One that is wanted; in order. `hidden`: see GroundMotionOptions.
  void see(FrameSource& source, std::int64_t index, const std::vector<Circle>& hidden);
  const GroundSample& sample() const { return sample_; }

 private:
  GroundSample sample_;
  CoarseShift coarse_;
  std::vector<std::int64_t> indices_;
  Picture whole_;
};
GroundSample sample_ground(FrameSource& source, std::int64_t first, std::int64_t last,
                           const GroundEffort& effort, const GroundMotionOptions& options);

/// What frames spread over the recording say of the ground.
struct GroundVerdict {
  bool visible = false;  ///< it shows a texture that locates it in both directions
  bool moves = false;    ///< and it does so beyond what its noise explains
  double texture = 0;    ///< grey levels rms beyond the noise
  double limit_px = 0;   ///< median standard deviation of the worse direction in a frame
  double motion_px = 0;  ///< rms displacement about its mean beyond the noise, per axis
  std::string reason;    ///< with its figure
};
GroundVerdict look_at_ground(const GroundSample& sample, double noise_variance);

struct GroundMotion {
  std::vector<std::optional<GroundFix>>
      frames;  ///< first .. last; nothing where the ground was not found again
  Ground ground;
  int learnt_from = 0;  ///< frames
  GroundVerdict verdict;
};

/// Learns, then measures every frame. No frames where the ground is not visible (verdict).
GroundMotion follow_ground(FrameSource& source, std::int64_t first, std::int64_t last,
                           const GroundMotionOptions& options);

}  // namespace tribotrack::vision
