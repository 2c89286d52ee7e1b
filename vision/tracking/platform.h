// How the platform moved: by a mark on it, or by its texture.
#pragma once

#include <optional>

#include "vision/following/pattern_follower.h"
#include "vision/tracking/target.h"

namespace tribotrack::vision {

/// The mark given or found; nothing where there is none, or where the texture is to serve.
std::optional<PatternFollower> plan_marker(const Picture& first, const FrameRange& range, FrameSource& source,
                                           const TrackOptions& options, double noise_variance,
                                           TrackSummary& summary);
/// Is the platform to be followed by its texture?
bool wants_texture(const TrackOptions& options, bool has_marker);
MarkerPoint marker_point(const Sighting& s);
/// The platform followed by a patch of its own texture, in a pass of its own: only now the part's path is
/// known.
void follow_texture(FrameSource& source, const Picture& first, std::int64_t first_index,
                    const TrackOptions& options, double noise_variance, const Pattern& part,
                    TrackResult& result);

}  // namespace tribotrack::vision
