// How the platform moves: by a mark on it, or by its ground.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "vision/following/pattern_follower.h"
#include "vision/stages/first_pass_result.h"
#include "vision/tracking/target.h"

namespace tribotrack::vision {

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
