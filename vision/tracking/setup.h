// Preparing to follow the part: the camera, the part's place in the first frame, its template, what the scene
// requires.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "vision/camera/pixels.h"
#include "vision/following/pattern_follower.h"
#include "vision/stages/first_pass_result.h"
#include "vision/tracking/target.h"

namespace tribotrack::vision {

inline constexpr int kCameraFrames = 6;  ///< looked at for the camera

struct Camera {
  double noise_variance = 0;  ///< grey levels^2
  std::vector<Pixel> bad_pixels;
};

/// From the first frames.
Camera check_camera(FrameSource& source, const FrameRange& range);

struct PartSetup {
  FirstPassResult result;         ///< as far as the first frames tell; the disc has radius 0 for a rectangle
  std::optional<DiscFit> rim;     ///< of the disc in the first frame, where it is seen
  std::optional<RimShape> shape;  ///< as its sectors show it, where enough do
  Pattern pattern;
  FollowOptions follow;
  AveragedTemplate average;
};

/// What is found out enters the summary, too. Throws InputError where the part cannot be followed from this
/// frame.
PartSetup set_up_part(const Picture& first, FrameSource& source, const FrameRange& range,
                      const Appearance& seen, const TrackOptions& options, double noise_variance,
                      TrackSummary& summary);

// Pictures of the first pass for debugging.

/// The template.
void show_template(const PartSetup& part, const Picture& first, DebugSink& sink);

/// Window, prediction by the template and residual in each of these frames, which are read again. `track` as
/// the first pass left it.
void show_first_pass(const PartSetup& part, const Picture& first, const Track& track,
                     const std::vector<ShownFrame>& frames, FrameSource& source, DebugSink& sink);

}  // namespace tribotrack::vision
