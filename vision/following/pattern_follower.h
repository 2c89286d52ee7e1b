// Following one template (the part, or the marker) from frame to frame.
//
// Each frame: predict, refine from the prediction; if the score does not confirm the match, correlate over a
// window about the prediction; if that fails too the part is lost and the whole frame is searched. A part
// found again far from where it was expected counts only once a second frame confirms it, and never where a
// known distractor is.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "vision/following/distractors.h"
#include "vision/following/motion_prediction.h"
#include "vision/frame_source.h"
#include "vision/registration/pattern.h"
#include "vision/registration/registration.h"
#include "vision/registration/template_match.h"
#include "vision/track.h"

namespace tribotrack::vision {

struct FollowOptions {
  double min_ncc = 0.6;
  double noise_variance = 1.0 / 12;
  double template_noise_share = 1;  ///< 1/M for a template averaged over M frames
  bool rotation = false;
  int search_margin_px = 0;  ///< 0: from the motion
  bool search_whole_frame = true;
};

/// The template seen in a frame.
struct Sighting {
  Point position;
  Pose pose;
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
  double ncc = 0;
  double residual_rms = 0;
  double excess_rms = 0;
  std::optional<HalvesError> halves;  ///< where they were asked for
};

struct FollowStep {
  TrackStatus status = TrackStatus::lost;
  std::optional<Sighting> sighting;
  bool tentative = false;          ///< sighting awaits confirmation by the next frame; status is lost
  bool confirms_previous = false;  ///< the previous frame's tentative sighting was right
};

/// What it took, for the plan.
struct FollowEffort {
  std::int64_t proved_by_refinement = 0;
  std::int64_t window_searches = 0;
  std::int64_t whole_frame_searches = 0;
};

class PatternFollower {
 public:
  /// `first` is the whole first analysed frame, number `index` in the source.
  PatternFollower(const Picture& first, std::int64_t index, const Pattern& pattern,
                  const FollowOptions& options);

  /// Frames must come in order. `audited`: the sighting's halves are compared.
  FollowStep step(FrameSource& source, std::int64_t index, bool audited = false);

  const FollowEffort& effort() const { return effort_; }

 private:
  enum class State { following, tentative, lost, left };
  std::optional<Sighting> near(FrameSource& source, std::int64_t index, const Point& predicted, double reach);
  std::optional<Sighting> refine(const Rect& window, const Pose& start, double max_distance);
  std::optional<Sighting> refine_any_angle(const Rect& window, const Pose& start, double max_distance);
  std::optional<Sighting> search(FrameSource& source, std::int64_t index);
  std::vector<Point> candidates(FrameSource& source, std::int64_t index);
  void remember_distractors(FrameSource& source);
  std::optional<HalvesError> halves();
  void accept(std::int64_t index, const Sighting& sighting);
  Pose pose_at(const Point& position, std::int64_t index) const;
  TrackStatus missing_status(const Rect& bounds, std::int64_t index) const;

  FollowOptions options_;
  Pattern pattern_;
  TemplateRegistration registration_;
  TemplateMatcher matcher_;
  double matcher_offset_x_, matcher_offset_y_;  ///< pattern's centre minus its window's first pixel
  double search_reference_ = 1;                 ///< score of the search template on the part itself
  State state_ = State::following;
  MotionPrediction motion_;
  std::optional<MotionPrediction> before_tentative_;
  State before_state_ = State::lost;
  std::vector<std::pair<std::int64_t, double>> angles_;  ///< last two
  double reference_ncc_ = 1;
  bool audited_ = false;             ///< the frame at hand
  std::optional<Sighting> outside_;  ///< seen, but reaching out of the picture
  Distractors distractors_;
  bool distractors_known_ = false;
  FollowEffort effort_;
  Picture picture_;  ///< work space
};

}  // namespace tribotrack::vision
