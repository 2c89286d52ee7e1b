// Tracking a part through a recording to a fraction of a pixel, with a standard deviation for every
// position.
//
// First pass: the part's picture in the first frame, averaged over more frames if its noise matters, is the
// template T. In each frame I the position d minimises the ZNCC criterion
//   sum_x w(x) [I(x) - a T(x - d) - b]^2,   a gain, b offset (and the rotation where T shows it),
// by Gauss-Newton from a prediction; a lost part is searched for by correlation. The covariance of d is the
// Cramer-Rao bound of T in the measured noise, widened where the residual exceeds the noise.
//
// Where T no longer looks like the part (brushed metal that turns under a lamp), only the part's edge is
// measured.
//
// Second pass (Layers), for discs: the appearance of the part, of the platform, and how much of the
// platform shows at every place of the part are learned from the recording itself, and every frame is
// measured again with these pictures, each place weighted by its residuals. An audit then tests the
// standard deviations on the recording itself and widens them where they do not hold. Where they clearly
// exceed what noise alone allows - the part turns, the light changes - the part's edge is measured in bands
// of time (edge/edge.h), regardless of what happens inside it, and kept if it is known better.
//
//   const auto source = open_source("slide.mp4", {.frame_rate_hz = 240});
//   TrackOptions options;
//   options.target = {Target::Kind::disc, {151, 87, 9}, {}};  // x, y, radius in the first frame, px
//   options.first_frame = 188;
//   const TrackResult result = track(*source, options);
//   if (!result.summary.gate_passed) std::cerr << result.summary.brief_report() << '\n';
//   for (const TrackPoint& p : result.track.points)
//     if (p.status == TrackStatus::ok) std::cout << p.time_s << ' ' << p.x << " +- " << p.sigma_x << '\n';
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "vision/frame_source.h"
#include "vision/track.h"

namespace tribotrack::vision {

/// Several discs may be the part: the user must say which it is.
class AmbiguousTarget : public InputError {
 public:
  AmbiguousTarget(const std::string& what, std::int64_t in_frame, bool at_the_start, std::vector<Circle> all)
      : InputError(what), frame(in_frame), first(at_the_start), discs(std::move(all)) {}
  std::int64_t frame;         ///< the recording's own number: in which all of them are seen
  bool first;                 ///< it is the first analysed frame
  std::vector<Circle> discs;  ///< numbered from 1 in this order
};

/// What to follow: a disc (template masked by its circle), any rectangle, or the disc found in the first
/// analysed frame. Pixel coordinates, see Point.
struct Target {
  enum class Kind { find_disc, disc, rectangle } kind = Kind::find_disc;
  Circle disc;
  Rect rectangle;
};

/// The mark fixed to the platform: a round one, found or given; a square tag; or the platform's own
/// texture, all of its visible ground. `find` falls back on the texture. Automatic: the texture if the
/// ground moves, else none.
struct MarkerChoice {
  enum class Kind { automatic, none, find, circle, texture, tag } kind = Kind::automatic;
  Circle circle;
  std::string dictionary = {};  ///< of the tag: "4x4_50", "apriltag_36h11", ... (vision/tags/tags.h)
  std::optional<int> id = {};   ///< empty: the only tag of that family in the picture
};

/// Throws std::invalid_argument, which names the families, unless this is a family of tags.
void require_tag_family(const std::string& dictionary);

/// Whether every frame is measured a second time with pictures learned from the recording. Automatic and
/// on: if the part is a disc whose edge is seen; kept if it does better than the first pass.
enum class Layers { automatic, off, on };

/// A picture of one stage of the tracking, for debugging.
struct StagePicture {
  std::string name;                        ///< short and unique but for the frame: fit for a file name
  std::string title;                       ///< what it shows
  std::optional<std::int64_t> frame = {};  ///< the recording's own number; empty: learnt from many frames
  std::string why_frame = {};              ///< why this frame was chosen: "first", "largest residual"
  Picture levels;                          ///< NaN where nothing is known
  std::string unit = "grey levels";
  Point first = {};           ///< place of the first pixel
  std::string place = {};     ///< the coordinates of that place: "of the camera", "of the platform"
  double low = 0, high = 0;   ///< range to draw; equal: that of the levels
  bool zero_centred = false;  ///< a difference: zero lies in the middle of the range
};

/// Receives the pictures of the stages: DebugFolder (overlay.h) writes them as PNG files.
class DebugSink {
 public:
  virtual ~DebugSink() = default;
  virtual void show(const StagePicture& picture) = 0;
};

struct TrackOptions {
  Target target;
  MarkerChoice marker;
  std::optional<Circle> gate;  ///< a lamp that is lit while the actuator is on: its brightness is recorded
  std::optional<std::int64_t> first_frame;  ///< the recording's own numbers, both included
  std::optional<std::int64_t> last_frame;
  std::int64_t frame_step = 1;  ///< every n-th frame from first_frame on
  double min_ncc = 0.6;         ///< matches with a lower correlation are rejected; 0 .. 1
  double max_lost_share = 0.1;  ///< of the frames: more lost ones and the track is not accepted; 0 .. 1
  Layers layers = Layers::automatic;
  /// Width of the disc's chamfer over its radius, where known; 0: its edge is sharp.
  std::optional<double> chamfer = {};
  int threads = 1;  ///< used on this recording; the result is the same for any number
  /// Frames of the work done and in all: the first of two passes counts for half.
  std::function<void(std::int64_t done, std::int64_t total)> progress;
  /// Kept only during track(). Sees the first, middle and last frame in which the part was found, and that
  /// with the largest residual.
  DebugSink* debug = nullptr;
  /// Throws std::invalid_argument naming the option.
  void validate() const;
};

/// Follows the target from the first analysed frame, or from that in which a disc is first seen there. The
/// template is taken there and never replaced (a replaced template drifts). Where the plan includes it, a
/// second pass measures every frame again (Layers). Throws InputError (target outside the picture, frames not
/// in the recording, no disc found, a given disc
/// not there, no time base), AmbiguousTarget where the part is to be found and several discs may be it.
TrackResult track(FrameSource& source, const TrackOptions& options);

}  // namespace tribotrack::vision
