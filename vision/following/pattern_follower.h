// Following one template (the part, or the marker) from frame to frame.
//
// Each frame: predict, refine from the prediction; if the score does not confirm the match, correlate over a
// window about the prediction; if that fails too the part is lost and the whole frame is searched. A part
// found again far from where it was expected counts only once a second frame confirms it, and never where a
// known distractor is. Where it may as well be another thing that looks alike - the part has jumped further
// than its own radius, or was lost, and more than one of its kind may have come to where it is found - the
// track ends: nothing tells them apart any more.
//
// A round part may change its look (metal that turns under a lamp): where its template no longer confirms the
// match, its rim does (rim_sectors.h). While that goes on the rim comes first, and the template is tried
// again at growing intervals.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "vision/discs/rim_sectors.h"
#include "vision/frame_source.h"
#include "vision/picture.h"
#include "vision/registration/pattern.h"
#include "vision/registration/registration.h"
#include "vision/track.h"

namespace tribotrack::vision {

/// Constant velocity through the last two positions, and how well that has worked.
class MotionPrediction {
 public:
  void add(std::int64_t frame, const Point& position);
  std::int64_t last_frame() const { return places_.back().frame; }
  Point last() const { return places_.back().position; }
  Point at(std::int64_t frame) const;
  /// How far from the prediction the thing may be, px: three times the recent rms error of prediction, grown
  /// with the number of frames since it was last seen.
  double reach(std::int64_t frame) const;
  /// Largest speed seen, px per frame.
  double top_speed() const { return top_speed_; }

 private:
  struct Place {
    std::int64_t frame = 0;
    Point position;
  };
  std::deque<Place> places_;
  double error_squared_ = 4;  ///< running mean, px^2; starts as ignorance
  double top_speed_ = 0;
};

// Distractors: things in the picture that look like the part but are not. Their positions are carried along,
// so that none of them is taken for a lost part.

/// Positions of distractors, carried from frame to frame by nearest neighbour.
class Distractors {
 public:
  /// `reach`: how far a distractor may be from where it was last seen, px.
  explicit Distractors(double reach) : reach_(reach) {}
  void clear() { places_.clear(); }
  void add(const Point& place) { places_.push_back(place); }
  const std::vector<Point>& places() const { return places_; }

  /// Takes the candidates of a new frame, gives each known distractor the nearest one within reach (nearest
  /// pairs first, one each), and returns those that are left: things not seen before. A distractor that is
  /// not seen (a hand covers it) keeps its place.
  std::vector<Point> unexplained(const std::vector<Point>& candidates);
  /// Whether most of them, two at least, were last given candidates further off than a quarter of the way to
  /// their nearest neighbour: then the whole scene has jumped, and which is which is a guess.
  bool all_moved() const { return all_moved_; }

 private:
  double reach_;
  std::vector<Point> places_;
  bool all_moved_ = false;
};

struct FollowOptions : RegistrationOptions {
  double min_ncc = 0.6;
  bool search_whole_frame = true;
};

/// The part seen in a frame: by its template, or by its rim alone. Then the correlation and the residual are
/// those of the edges fitted to the rim, and the angle is as predicted.
struct Sighting : Registration {
  Point position;
  std::optional<HalvesError> halves = {};  ///< where they were asked for
  bool by_rim = false;                     ///< the template did not confirm the match
};

struct FollowStep {
  TrackStatus status = TrackStatus::lost;
  std::optional<Sighting> sighting;  ///< if not ok, it awaits confirmation by the next frame
  bool confirms_previous = false;    ///< the previous frame's tentative sighting was right
  bool came_back = false;            ///< so it was, of a part that had left the picture
};

class PatternFollower {
 public:
  /// `first` is the whole first analysed frame, number `index` in the source. With a `rim` the part is also
  /// found where it no longer looks like the template.
  PatternFollower(const Picture& first, std::int64_t index, const Pattern& pattern,
                  const FollowOptions& options, std::optional<RimShape> rim = {});

  /// Frames must come in order. `audited`: the sighting's halves are compared.
  FollowStep step(FrameSource& source, std::int64_t index, bool audited = false);

  /// Index of the frame since which the part cannot be told from others.
  const std::optional<std::int64_t>& ended() const { return ended_; }

 private:
  enum class State { following, tentative, lost, left };
  std::optional<Sighting> near(FrameSource& source, std::int64_t index, const Point& predicted, double reach);
  std::optional<Sighting> by_template(const Rect& window, std::int64_t index, const Point& predicted,
                                      double reach, Point& place);
  std::optional<Sighting> by_rim(const Rect& window, std::int64_t index, const Point& place, double reach);
  std::vector<Point> matches(const Rect& window, double separation, int most) const;
  double own_radius() const;
  std::optional<Sighting> refine(const Rect& window, const Pose& start, double max_distance);
  std::optional<Sighting> refine_any_angle(const Rect& window, const Pose& start, double max_distance);
  std::optional<Sighting> search(FrameSource& source, std::int64_t index);
  std::optional<Sighting> found_again(const Rect& bounds, std::int64_t index, const Point& place);
  bool may_be_back() const;
  std::vector<Point> candidates();
  void remember_distractors(FrameSource& source);
  bool may_be_another(FrameSource& source, std::int64_t index, const Point& place);
  double unwrapped(double theta, std::int64_t index) const;
  void accept(std::int64_t index, Sighting& sighting);
  Pose pose_at(const Point& position, std::int64_t index) const;

  FollowOptions options_;
  Pattern pattern_;
  TemplateRegistration registration_;
  TemplateMatcher matcher_;
  double search_reference_ = 1;  ///< score of the search template on the part itself
  State state_ = State::following;
  MotionPrediction motion_;
  std::optional<MotionPrediction> before_tentative_;
  State before_state_ = State::lost;
  std::vector<std::pair<std::int64_t, double>> angles_;  ///< last two
  double reference_ncc_ = 1;
  bool audited_ = false;  ///< the frame at hand
  std::optional<RimShape> rim_;
  int template_rest_ = 0,
      template_pause_ = 0;           ///< frames until the template is tried again; the last such pause
  std::optional<Sighting> outside_;  ///< seen, but reaching out of the picture
  Distractors distractors_;
  bool distractors_known_ = false;  ///< those of the last frame in which the part was seen
  std::optional<std::int64_t> ended_;
  Picture fruitless_;  ///< the last frame in which a search of it all found nothing
  Picture picture_;    ///< work space
};

// A quieter template: the first frames laid on each other.
//
// The noise of a single template goes into its derivatives, which costs accuracy, and into the residual at
// every fraction of a pixel anew. Averaged over M frames aligned with the first it has 1/M of that variance.
// It is never replaced afterwards: a replaced template drifts.

inline constexpr int kAveragedFrames = 24;  ///< at most, the first included

struct AveragedTemplate {
  Picture averaged;  ///< the first frame with the template's surroundings averaged; empty for one frame alone
  int frames = 1;    ///< M
  const Picture& picture(const Picture& first) const { return averaged.empty() ? first : averaged; }
};

/// Follows the pattern through the frames after `index` (up to `last`) with the single template and averages
/// what it finds, where the single one's noise, which adds `noise_cost` to the variance, matters. Tells
/// `follow` how much of it is left. The part must not turn. One frame alone where fewer than four match.
AveragedTemplate quiet_template(FrameSource& source, const Picture& first, std::int64_t index,
                                std::int64_t last, const Pattern& pattern, double noise_cost,
                                FollowOptions& follow);
inline constexpr double kQuietTemplate = 0.002;  ///< relative variance below which averaging does not pay

// Check of the part's texture: does what looks like one in the first frame belong to the part?
//
// A coder leaves marks of its own where it drops the noise, and drops them anew in later frames: they stand
// out of the noise between frames as scratches would, but do not come again with the part.

/// Follows the disc, whose edge has that blur, through the frames after `index` (up to `last`), its rotation
/// included, and asks its rings (vision/rotation/rotation.h). False only where it is found and they do not
/// look as in the first frame at any angle.
bool texture_returns(FrameSource& source, const Picture& first, std::int64_t index, std::int64_t last,
                     const Pattern& disc, double blur, const FollowOptions& follow);

}  // namespace tribotrack::vision
