// What the first pass leaves to the second, beside the track.
#pragma once

#include <Eigen/Core>
#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "vision/audit/halves.h"
#include "vision/frame_source.h"
#include "vision/picture.h"
#include "vision/track.h"
#include "vision/tracker.h"

namespace tribotrack::vision {

struct FrameRange {
  std::int64_t first = 0, last = 0;  ///< indices, both included
  std::int64_t count() const { return last - first + 1; }
};

/// From the recording's own numbers. Throws InputError where it does not hold them.
FrameRange frames_to_analyse(const FrameSource& source, const TrackOptions& options);

/// Tracks every n-th frame, as the options say, by `run`; again without the pictures that repeat others, if
/// the first run meets such: these become points of status `repeat`. Throws InputError for weaved fields.
TrackResult track_each_picture_once(
    FrameSource& recording, const TrackOptions& options,
    const std::function<TrackResult(FrameSource& source, const TrackOptions& options)>& run);

/// How a frame showed the part, beside its place; nothing is known where it was not ok.
struct PartLook {
  double theta = 0;        ///< rotation, as its texture shows it, rad
  double sigma_theta = 0;  ///< its standard deviation; 0 where it was not measured
  double residual = 0;     ///< grey levels rms
  bool by_rim = false;     ///< the template was not confirmed: by the rim alone, theta as predicted
};

struct FirstPassResult {
  std::int64_t first_index = 0;     ///< of the track's first point in the source
  std::int64_t total = 0;           ///< frames analysed
  Circle disc;                      ///< in the first frame
  double blur = 0;                  ///< of its rim, px; 0 where the part is not a disc
  double contrast = 0;              ///< across it, grey levels; 0 where the part is not a disc
  double limit_px = 0;              ///< Cramer-Rao bound of a coordinate by the template
  bool turning = false;             ///< the part's texture shows its rotation
  bool texture_seen = false;        ///< in the first frame there is a texture that would show it
  std::vector<PartLook> looks;      ///< one per point
  std::vector<AuditFrame> audited;  ///< frames whose halves were compared, none measured by the rim
  double noise_variance = 0;
  double ground_texture = 0;  ///< about the part in the first frame, grey levels rms beyond the noise
  double excess = 0;          ///< median residual beyond the noise, grey levels rms
};

/// A frame as the first pass left it.
struct FirstPassFrame {
  std::int64_t index = 0;
  Point centre;
  Point ground = {};      ///< the platform's displacement since the first frame
  std::size_t place = 0;  ///< of its point in the track
};
using SeenFrames = std::vector<FirstPassFrame>;

/// The frames in which the part was found and, if asked for, the marker where there is one. `first_index` is
/// that of the track's first point in the source.
inline SeenFrames seen_frames(const Track& track, std::int64_t first_index, bool with_marker = false) {
  SeenFrames seen;
  const MarkerPoint* origin = nullptr;
  for (std::size_t k = 0; k < track.points.size(); ++k) {
    const TrackPoint& p = track.points[k];
    if (p.status != TrackStatus::ok || (with_marker && track.has_marker && !p.marker)) continue;
    FirstPassFrame f{first_index + static_cast<std::int64_t>(k), {p.x, p.y}, {}, k};
    if (p.marker) {
      if (!origin) origin = &*p.marker;
      f.ground = {p.marker->x - origin->x, p.marker->y - origin->y};
    }
    seen.push_back(f);
  }
  return seen;
}

/// A position measured again.
struct Remeasured {
  Point centre;
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  ///< px^2
  std::optional<double> ncc = {};
};

/// The positions in some frames of a track, as they are and as they were measured again.
struct Remeasurement {
  std::size_t count = 0;         ///< measured
  Point moved;                   ///< mean, px
  double differ = 0;             ///< px rms of a coordinate, without the mean
  double sd = 0, median_sd = 0;  ///< px of a coordinate as measured again: rms, median
};
Remeasurement compare(const Track& track, const SeenFrames& frames,
                      const std::vector<std::optional<Remeasured>>& fixes);
void replace(Track& track, const SeenFrames& frames, const std::vector<std::optional<Remeasured>>& fixes);

/// What a pass that measures the frames again found out, for the track's summary.
struct PassOutcome {
  PlanStage stage;  ///< off: the track is as it was
  std::vector<std::string> warnings;
  double limit_px = 0;                ///< median standard deviation of a coordinate
  double slow_sd = 0, slow_time = 0;  ///< see TrackSummary
  std::vector<AuditFrame> audited;    ///< frames whose halves were compared
};

// What is shown to TrackOptions::debug: which frames, and in which range of levels.

/// Why a frame of status ok is shown, by its index in the source.
using ShownFrames = std::map<std::int64_t, std::string>;

/// None without TrackOptions::debug.
ShownFrames frames_to_show(const Track& track, const FirstPassResult& first, const TrackOptions& options);

/// What a stage predicts of a window of a frame, and what it leaves of it: pictures `stage`_predicted and
/// `stage`_residual. `seen` is the window, with frame and first pixel; the prediction is drawn in its range.
void show_prediction(const StagePicture& seen, Picture predicted, const std::string& stage,
                     const std::string& title, const std::string& residual_title, DebugSink& sink);

/// The camera's picture in a window of a frame that is shown, all of its range.
StagePicture window_of(FrameSource& source, const ShownFrames::value_type& shown, const Rect& window);

// Where the time goes: every moment of the tracking belongs to exactly one stage.

/// A stage that calls another is interrupted by it, so that the times add up to the whole. A change of stage
/// costs one reading of the steady clock. Only the thread that made the clock changes stages: what others do
/// meanwhile belongs to the stage in which they were started.
class StageClock {
 public:
  class [[nodiscard]] Running {
   public:
    ~Running() { clock_.switch_to(interrupted_); }
    Running(const Running&) = delete;
    Running& operator=(const Running&) = delete;

   private:
    friend class StageClock;
    Running(StageClock& clock, const char* stage)
        : clock_(clock), interrupted_(clock.is_own() ? clock.now_in_ : kOther) {
      clock.switch_to(stage);
    }
    StageClock& clock_;
    const char* interrupted_;
  };

  /// Time counts for `stage` until what is returned is destroyed, then again for the interrupted stage.
  Running enter(const char* stage) { return {*this, stage}; }
  /// In the order of the work; what belongs to no stage comes last.
  std::vector<StageTime> times();

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr const char* kOther = "other";
  bool is_own() const { return std::this_thread::get_id() == owner_; }
  void switch_to(const char* next);
  std::thread::id owner_ = std::this_thread::get_id();
  const char* now_in_ = kOther;
  Clock::time_point since_ = Clock::now();
  std::vector<StageTime> spent_;
};

/// A recording whose reads are a stage.
class TimedSource : public FrameSource {
 public:
  /// Keeps references.
  TimedSource(FrameSource& source, StageClock& clock) : source_(source), clock_(clock) {
    info_ = source.info();
  }
  void fill(std::int64_t index, const Rect& window, Picture& picture) override {
    const auto timed = clock_.enter("reading and decoding");
    source_.read(index, window, picture);
  }

 private:
  FrameSource& source_;
  StageClock& clock_;
};

}  // namespace tribotrack::vision
