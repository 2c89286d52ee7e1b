// What the second pass is given: the frames as the first pass left them.
#pragma once

#include <cstdint>
#include <vector>

#include "vision/track.h"

namespace tribotrack::vision {

/// A frame as the first pass left it.
struct FirstPassFrame {
  std::int64_t index = 0;
  Point centre;
  Point ground = {};  ///< the platform's displacement since the first frame
};

struct SeenFrames {
  std::vector<FirstPassFrame> frames;
  std::vector<std::size_t> places;  ///< in the track
};

/// The frames in which the part was found and, if asked for, the marker where there is one. `first_index` is
/// that of the track's first point in the source.
inline SeenFrames seen_frames(const Track& track, std::int64_t first_index, bool with_marker = false) {
  SeenFrames seen;
  const MarkerPoint* origin = nullptr;
  for (std::size_t k = 0; k < track.points.size(); ++k) {
    const TrackPoint& p = track.points[k];
    if (p.status != TrackStatus::ok || (with_marker && track.has_marker && !p.marker)) continue;
    FirstPassFrame f{first_index + static_cast<std::int64_t>(k), {p.x, p.y}};
    if (p.marker) {
      if (!origin) origin = &*p.marker;
      f.ground = {p.marker->x - origin->x, p.marker->y - origin->y};
    }
    seen.frames.push_back(f);
    seen.places.push_back(k);
  }
  return seen;
}

/// Frames spread over a recording that the layers are learnt from, as far as the part is seen in them. The
/// layers' own noise adds 1 / kLearningFrames to the variance.
inline constexpr std::int64_t kLearningFrames = 128;
/// Whether the frame at this place (0 .. total - 1) of those analysed is one of them.
bool is_learning_frame(std::int64_t place, std::int64_t total);
/// Half width of the part's grid, px: the part with its rim and its shadow.
int layered_half(double radius, double blur);
/// Px about the part's centre that are looked at in every frame.
double layered_reach(double radius, double blur);

}  // namespace tribotrack::vision
