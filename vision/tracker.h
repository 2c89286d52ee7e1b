// Following a part through a recording by normalised cross-correlation template matching with sub-pixel
// refinement.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

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

/// A stage of the work that a scene may or may not need.
struct PlanStage {
  std::string name;
  bool on = false;
  std::string reason;           ///< with its figure
  double predicted_saving = 0;  ///< share of run time that leaving it out saves (on) or saved (off), 0 .. 1
  double error_bound_px = 0;    ///< what leaving it out can add
  double cost = 0;              ///< predicted, see plan_costs.h
};

struct TrackSummary {
  Circle disc;                ///< as tracked in the first frame: given or found, px
  double disc_blur = 0;       ///< s, Gaussian sd of its edge with the pixel in it, px; 0 where not measured
  double disc_radius_sd = 0;  ///< px, 0 where not measured
  /// Part of it, px, that every recording of this part shares (MeanRadius::common_sd).
  double disc_radius_common_sd = 0;
  Circle marker;
  Rect texture_patch;             ///< where the platform's own texture serves as its marker; else of no width
  int gate_pixels = 0;            ///< pixels averaged over the lamp, 0 without one
  double gate_clipped_share = 0;  ///< of them, at the top level in the frame where that was most
  double noise_levels = 0;  ///< picture noise used for sigma, grey levels, the 1/12 of rounding included
  double limit_px = 0;      ///< Cramer-Rao bound of one coordinate, px; of the layered model where it is used
  bool layered = false;     ///< positions come from the layered second pass
  std::int64_t frames = 0, ok = 0, lost = 0, edge = 0, refound = 0;
  std::int64_t absent_at_first = 0;  ///< frames before the part was there; lost, too
  /// Lost frames, those before it was there and after it had left the picture for good not counted.
  std::int64_t lost_counted = 0;
  bool gate_passed = true;  ///< lost_counted / frames <= max_lost_share
  bool left_for_good = false;
  std::vector<PlanStage> plan;
  std::vector<std::string> warnings;
  std::string brief_report() const;
};

struct TrackResult {
  Track track;
  TrackSummary summary;
};

/// Follows the target from the first analysed frame, or from that in which a disc is first seen there. The
/// template is taken there and never replaced (a replaced template drifts). Where the plan says so, a second
/// pass measures every frame again (Layers). Throws InputError (target outside the picture, frames not in the
/// recording, no disc found, no time base).
TrackResult track(FrameSource& source, const TrackOptions& options);

}  // namespace tribotrack::vision
