// Following a part through a recording by normalised cross-correlation template matching with sub-pixel
// refinement.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>

#include "vision/frame_source.h"
#include "vision/track.h"

namespace tribotrack::vision {

/// What to follow: a disc (template masked by its circle), any rectangle, or the disc found in the first
/// analysed frame.
struct Target {
  enum class Kind { find_disc, disc, rectangle } kind = Kind::find_disc;
  Circle disc;
  Rect rectangle;
};

/// The mark fixed to the platform: a round one found or given, or a patch of the platform's own texture that
/// the part never covers. `find` falls back on texture.
struct MarkerChoice {
  enum class Kind { none, find, circle, texture } kind = Kind::none;
  Circle circle;
};

/// Whether the disc is measured a second time over the platform's own picture, both learnt from the recording
/// (layered_pass.h). Automatic: where the ground's texture or a change of light leaves its mark on a single
/// template, and the platform rests or has a marker. On: also where it does not.
enum class Layers { automatic, off, on };

struct TrackOptions {
  Target target;
  MarkerChoice marker;
  std::optional<Circle> gate;               ///< a lamp whose brightness is recorded, frame by frame
  std::optional<std::int64_t> first_frame;  ///< recording's own numbers, both included
  std::optional<std::int64_t> last_frame;
  double min_ncc = 0.6;  ///< below this a match is not believed
  double max_lost_share =
      0.1;  ///< quality gate: share of frames that may be lost (after-it-left frames not counted)
  int search_margin_px =
      0;  ///< half width of the predicted window beyond the template; 0: chosen from the motion
  Layers layers = Layers::automatic;
  std::function<void(std::int64_t done, std::int64_t total)> progress;
  /// Throws std::invalid_argument naming the option.
  void validate() const;
};

/// Follows the target from the first analysed frame, or from that in which a disc is first seen there. The
/// template is taken there and never replaced (a replaced template drifts). Where the plan says so, a second
/// pass measures every frame again (Layers). Throws InputError (target outside the picture, frames not in the
/// recording, no disc found, no time base).
TrackResult track(FrameSource& source, const TrackOptions& options);

}  // namespace tribotrack::vision
