// How the platform moves: by a mark on it, or by its texture.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "vision/following/pattern_follower.h"
#include "vision/tracking/target.h"

namespace tribotrack::vision {

struct MarkerSetup {
  std::optional<PatternFollower> follower;  ///< empty: no mark, or the texture is to be used
  Circle circle;
  std::vector<PlanStage> plan;
  std::vector<std::string> warnings;
};

/// The mark given or found; `part` is not the mark.
MarkerSetup set_up_marker(const Picture& first, FrameSource& source, const FrameRange& range,
                          const TrackOptions& options, double noise_variance, const Circle& part);

MarkerPoint marker_point(const Sighting& s);

/// Whether the platform is to be followed by its texture.
bool wants_texture(const TrackOptions& options, bool has_marker);

struct TextureMarker {
  Rect patch;
  PlanStage stage;
  std::int64_t lost = 0;  ///< frames in which it was not found
};

/// Follows a patch of the platform's texture that the part never covers, in a pass of its own: the part's
/// whole path must be known. Fills in the track's markers. Throws InputError where there is no such patch.
TextureMarker follow_texture(FrameSource& source, const Picture& first, std::int64_t first_index,
                             const TrackOptions& options, double noise_variance, const Pattern& part,
                             Track& track);
/// The patch as a round mark.
Circle circle_in(const Rect& patch);

}  // namespace tribotrack::vision
