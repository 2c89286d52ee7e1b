// The second pass, the part's own pictures over the ground's, learnt from the recording itself: whether it
// pays, and what it changes in a track.
//
// To a first pass with a single template the ground seen through the rim, the part's shadow and whatever
// turns in it look like motion. This pass keeps a bounded number of windows spread over the recording, learns
// from them the ground's picture and the part's (model/model.h), and then measures every frame again. Reads
// the recording forwards, once for what is learnt and once to measure; of a decoded recording mostly what the
// first pass has cached (read_again()). Memory does not grow with its length.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <vector>

#include "vision/audit/halves.h"
#include "vision/frame_source.h"
#include "vision/layers/model/model.h"
#include "vision/layers/registration/registration.h"
#include "vision/stages/stages.h"

namespace tribotrack::vision {

/// Measures every frame again over the platform's own picture where that pays: positions, standard deviations
/// and correlations of the track's ok points change, never their status. `shown` frames go to
/// TrackOptions::debug.
PassOutcome layered_stage(FrameSource& source, const FirstPassResult& first, const TrackOptions& options,
                          const ShownFrames& shown, StageClock& clock, Track& track);

/// Frames spread over a recording that the layers are learnt from, as far as the part is seen in them. The
/// layers' own noise adds 1 / kLearningFrames to the variance.
inline constexpr std::int64_t kLearningFrames = 128;
/// Whether the frame at this place (0 .. total - 1) of those analysed is one of them.
bool is_learning_frame(std::int64_t place, std::int64_t total);
/// Half width of the part's grid, px: the part with its rim and its shadow.
int layered_half(double radius, double blur);

/// Of a frame in which the part is seen: what the second pass, and the rotation by rings, will read again. A
/// window about the part, or all of a frame that the layers are probably learnt from; empty for nothing.
Rect read_again(const FirstPassResult& first, Layers layers, std::int64_t index, const Point& centre,
                const Rect& bounds);

// Learning the part's pictures from kept windows: which pictures, and where in each window?
//
// Each round learns the pictures from the windows in their present states, then measures the windows over
// them, until the windows hardly move.

struct LearntPart {
  PartPictures part;
  IlluminationSlope light;
  double chi_squared = 1;  ///< per pixel, of the usual window
  double sigma = 0;        ///< of a coordinate of the usual window, px
  int rounds = 0;
  std::size_t explained = 0;  ///< windows
};

/// Changes the windows' states, and tells the ground what is seen of it beside the part: within `hidden` px
/// of the part none has been seen yet. The result is the same for any number of threads. `registration` is
/// left with the pictures learnt.
LearntPart learn_part(std::vector<KeptWindow>& windows, GroundPicture& ground,
                      LayeredRegistration& registration, const FirstPassResult& first, double hidden,
                      int threads);

/// Over a run of frames, about each cluster's mean: what stays the same for the whole run moves all its
/// positions alike, which is no error of a displacement.
struct RunScatter {
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  ///< of a position, px^2
  double white = 0;        ///< variance of a coordinate by the change from one frame to the next, px^2
  double slow = 0;         ///< what the covariance has beyond it
  double slow_frames = 0;  ///< over how many frames that stays alike: the integral of its correlation
};

/// `taken`: the share of the squares that the position has taken, along x and y.
RunScatter run_scatter(const std::vector<ClusterPulls>& frames, const Eigen::Array2d& taken);

struct MeasuredFrames {
  /// One per frame, nullopt where the model does not hold (too near the border, something in the way). Their
  /// covariances are what the residuals support, see run_scatter().
  std::vector<std::optional<LayeredFix>> fixes;
  /// Errors that neighbouring frames share, in the covariances: standard deviation of a coordinate, px, and
  /// over how many frames they stay alike.
  double slow_sd = 0, slow_frames = 0;
  std::vector<AuditFrame> audited;  ///< of some of the frames, their halves compared
};

/// `registration` holds the pictures learnt. `progress` may be empty.
MeasuredFrames measure_frames(FrameSource& source, const SeenFrames& frames,
                              const LayeredRegistration& registration, const LearntPart& learnt, int threads,
                              const std::function<void(std::int64_t done)>& progress);

// Pictures of the learnt layers for debugging.

/// Part, share of the ground, ground; of each of the shown frames, which are read again, prediction and
/// residual in its measured state.
void show_layers(const PartPictures& part, const GroundPicture& ground, const MeasuredFrames& measured,
                 const SeenFrames& frames, const ShownFrames& shown, FrameSource& source, DebugSink& sink);

// The windows the layers are learnt from, and the platform's picture from the same frames.

/// Frames spread over the recording, as many as memory has room for.
class LearningFrames {
 public:
  /// Keeps references. `reach` px about the part's centre.
  LearningFrames(FrameSource& source, const SeenFrames& frames, const FirstPassResult& first, double reach);

  const Rect& region() const { return region_; }
  std::size_t count() const { return chosen_.size(); }

  /// Their windows, in the order of time.
  std::vector<KeptWindow> read_windows() const;
  /// The ground, averaged from frames spread over the recording; there is none within `hidden` px of the
  /// part.
  void read_ground(GroundPicture& ground, double hidden) const;

 private:
  FrameSource& source_;
  const SeenFrames& frames_;
  const FirstPassResult& first_;
  double reach_;
  Rect region_, read_;                               ///< the latter of every frame
  std::vector<std::size_t> chosen_, ground_frames_;  ///< of frames_
};

}  // namespace tribotrack::vision
