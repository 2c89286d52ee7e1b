// Preparing to follow the part - camera, its place in the first frame, its template, what the scene requires
// - and the platform, by a mark or by its ground; and what a track's summary reports of it.
#pragma once

#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "vision/camera/pixels.h"
#include "vision/following/pattern_follower.h"
#include "vision/stages/stages.h"
#include "vision/tracker.h"
#include "vision/tracking/target.h"

namespace tribotrack::vision {

// What a track's summary reports: counts, the plan's stages, warnings.

/// Frames by their status, and the quality gate.
FrameCounts count(const Track& track, double max_lost_share);

/// What the ground shows; `learnt_from` frames, 0: it is not followed.
PlanStage ground_marker_stage(const std::string& ground, int learnt_from);
std::string no_rim_warning(const char* what, const Circle& given);
/// A disc that was found, not given, and never moves may be a mark on the table; one that goes where the
/// ground or the mark goes may be fixed to it.
std::optional<std::string> rest_warning(const Track& track, const Circle& disc, bool against_marker);

/// What is taken for a part that has left and come back, from point number `begin` until it is lost again,
/// must move, or else it is a mark on the ground: then those points become lost, and it is said.
std::optional<std::string> without_a_mark(Track& track, std::size_t begin);

/// Appends all of them, or the one that there may be.
template <class Item, class Items>
void add(std::vector<Item>& to, const Items& items) {
  if constexpr (std::is_same_v<Items, std::optional<Item>>) {
    if (items) to.push_back(*items);
  } else {
    to.insert(to.end(), items.begin(), items.end());
  }
}

// The part.

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

/// The template; window, prediction by the template and residual in each of these frames, which are read
/// again. `track` as the first pass left it.
void show_first_pass(const PartSetup& part, const Picture& first, const Track& track,
                     const ShownFrames& frames, FrameSource& source, DebugSink& sink);

// How the platform moves: by a mark on it, or by its ground.

/// Of the mark given or found, of which the summary is told; `part` is not the mark. Nothing where there is
/// none, or the ground is to be used.
std::optional<PatternFollower> set_up_marker(const Picture& first, FrameSource& source,
                                             const FrameRange& range, const TrackOptions& options,
                                             double noise_variance, const Circle& part,
                                             TrackSummary& summary);

/// What lies over the ground: the part there with its shadow, the lamp.
std::vector<Circle> over_ground(const Point& part, const Pattern& pattern, const TrackOptions& options);

/// Follows all of the ground that is seen, in a pass of its own: the part's whole path must be known. Fills
/// in the track's markers, and says so in the summary. Where the ground shows too little: throws InputError
/// if it was asked for.
void follow_platform(FrameSource& source, const FirstPassResult& first, const TrackOptions& options,
                     const Pattern& part, Track& track, TrackSummary& summary);

}  // namespace tribotrack::vision
