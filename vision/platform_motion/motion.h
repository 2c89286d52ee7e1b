// The platform's motion from its ground, as much of it as is seen: no mark is needed.
//
//   GroundMotionOptions options;
//   options.noise_variance = camera.noise_variance;
//   options.hidden = [&](std::int64_t index) { return std::vector<Circle>{part_with_shadow(index)}; };
//   const GroundSample sample = sample_ground(source, first, last, kGroundGlance, options);
//   if (const GroundVerdict seen = look_at_ground(sample, options); seen.moves) {
//     const GroundMotion motion = follow_ground(source, first, last, options);
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
#include "vision/platform_motion/learning.h"

namespace tribotrack::vision {

struct GroundMotionOptions {
  double noise_variance = 1.0 / 12;  ///< of a pixel, grey levels^2: the least that is believed
  /// What lies over the ground in a frame: the part with its shadow, a lamp. Others that cross are trimmed.
  std::function<std::vector<Circle>(std::int64_t index)> hidden = [](std::int64_t) {
    return std::vector<Circle>{};
  };
};

inline constexpr int kGroundGlance = 16;  ///< frames that tell whether the ground moves
inline constexpr int kGroundFrames = 128; ///< it is learnt from: their noise adds less than a hundredth

/// Frames kept for the learning.
struct GroundSample {
  std::vector<Rect> fields;
  std::vector<GroundFrame> frames;
};

/// Frames spread evenly over first .. last, read whole, kept as far as they show the fields. At most `frames`,
/// fewer of large pictures.
GroundSample sample_ground(FrameSource& source, std::int64_t first, std::int64_t last, int frames,
                           const GroundMotionOptions& options);

/// What frames spread over the recording say of the ground.
struct GroundVerdict {
  bool visible = false;  ///< it shows a texture that locates it in both directions
  bool moves = false;    ///< and it does so beyond what its noise explains
  double texture = 0;    ///< grey levels rms beyond the noise
  double limit_px = 0;   ///< median standard deviation of the worse direction in a frame
  double motion_px = 0;  ///< rms displacement about its mean beyond the noise, per axis
  std::string reason;    ///< with its figure
};
GroundVerdict look_at_ground(const GroundSample& sample, const GroundMotionOptions& options);

struct GroundMotion {
  std::vector<std::optional<GroundFix>> frames;  ///< first .. last; nothing where the ground was not found again
  Ground ground;
  Point anchor;         ///< middle of the ground's information, in the first frame, px
  int learnt_from = 0;  ///< frames
  GroundVerdict verdict;
};

/// Learns from the sample, then measures every frame. Nothing where the ground shows nothing.
std::optional<GroundMotion> follow_ground(FrameSource& source, std::int64_t first, std::int64_t last,
                                          const GroundMotionOptions& options);

}  // namespace tribotrack::vision
