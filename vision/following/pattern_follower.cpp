#include "vision/following/pattern_follower.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "vision/kernels/plane.h"

namespace tribotrack::vision {
namespace {

constexpr double kEdgeMargin = 1.0;       ///< px around the part that must be in the picture
constexpr double kNccDrop = 0.8;          ///< of the usual score: a match below it is rejected
constexpr double kRefoundNccDrop = 0.88;  ///< the same for a part found far from where it was expected
/// Correlations that differ by less may be those of two pictures of the same part.
constexpr double kSameLook = 0.05;
constexpr int kMostAlike = 100;  ///< things that look like the part, in a whole frame
constexpr int kAngles = 24;
constexpr double kCandidateReach = 2.5;  ///< px from a whole position to what is refined there
constexpr double kChangedContrast = 0.5, kChangedArea = 0.125;  ///< of the template's spread and mask
constexpr int kLongestPause = 63;  ///< frames: a template tried once in so many costs nothing

}  // namespace

PatternFollower::PatternFollower(const Picture& first, std::int64_t index, const Pattern& pattern,
                                 const FollowOptions& options, std::optional<RimShape> rim)
    : options_(options),
      pattern_(pattern),
      registration_(first, pattern, options),
      matcher_(search_template(first, pattern)),
      rim_(std::move(rim)),
      distractors_(std::max(6.0, pattern.reach())) {
  search_reference_ = matcher_.score(first, pattern.window.x, pattern.window.y);
  motion_.add(index, pattern.centre);
}

FollowStep PatternFollower::step(FrameSource& source, std::int64_t index, bool audited) {
  audited_ = audited;
  const Rect bounds = source.bounds();
  FollowStep out;
  if (ended_) return out;
  outside_.reset();
  if (state_ == State::following || state_ == State::tentative) {
    const Point predicted = motion_.at(index);
    const double reach = std::clamp(motion_.reach(index), 3.0, std::max(40.0, pattern_.reach()));
    if (pattern_.inside(bounds, predicted, kEdgeMargin - reach)) {
      out.sighting = near(source, index, predicted, reach);
      if (out.sighting) {
        out.confirms_previous = state_ == State::tentative;
        out.came_back = out.confirms_previous && before_state_ == State::left;
        accept(index, *out.sighting);
        state_ = State::following;
        out.status = TrackStatus::ok;
        return out;
      }
    }
    if (ended_) return out;
    if (state_ == State::tentative) {
      motion_ = *before_tentative_;
      state_ = before_state_;
    } else {
      distractors_known_ = false;
      const bool at_edge =
          outside_ || !pattern_.inside(bounds, predicted, kEdgeMargin + std::min(reach, 3.0));
      state_ = at_edge ? State::left : State::lost;
      if (outside_) {  // extrapolate from here
        motion_.add(index, outside_->position);
        out.status = TrackStatus::edge;
        return out;
      }
    }
  }
  if (options_.search_whole_frame) {
    out.sighting = search(source, index);
    if (ended_) return out;
    if (out.sighting) {
      before_tentative_ = motion_;
      before_state_ = state_;
      if (index - motion_.last_frame() > 3) motion_ = MotionPrediction();
      accept(index, *out.sighting);
      state_ = State::tentative;
    }
  } else if (state_ == State::lost) {
    out.sighting = near(source, index, motion_.last(), std::max(40.0, pattern_.reach()));
    if (out.sighting) {
      accept(index, *out.sighting);
      state_ = State::following;
      out.status = TrackStatus::ok;
      return out;
    }
  }
  if (state_ == State::left && pattern_.overlaps(bounds, motion_.at(index))) out.status = TrackStatus::edge;
  return out;
}

Pose PatternFollower::pose_at(const Point& position, std::int64_t index) const {
  Pose pose{position.x - pattern_.centre.x, position.y - pattern_.centre.y, 0};
  if (!angles_.empty()) {
    pose.theta = angles_.back().second;
    if (angles_.size() == 2 && angles_[1].first - angles_[0].first == 1 && index - angles_[1].first <= 2)
      pose.theta += static_cast<double>(index - angles_[1].first) * (angles_[1].second - angles_[0].second);
  }
  return pose;
}

/// Turns by whole ones to the nearest of what the two angles before let expect.
double PatternFollower::unwrapped(double theta, std::int64_t index) const {
  double expected = angles_.empty() ? 0 : angles_.back().second;
  if (angles_.size() == 2)
    expected += static_cast<double>(index - angles_[1].first) * (angles_[1].second - angles_[0].second) /
                static_cast<double>(angles_[1].first - angles_[0].first);
  return theta + 2 * std::numbers::pi * std::round((expected - theta) / (2 * std::numbers::pi));
}

void PatternFollower::accept(std::int64_t index, Sighting& sighting) {
  motion_.add(index, sighting.position);
  if (sighting.by_rim) {
    if (template_rest_ == 0)
      template_rest_ = template_pause_ = std::min(2 * template_pause_ + 1, kLongestPause);
    else
      --template_rest_;
    return;
  }
  template_rest_ = template_pause_ = 0;
  // Slowly: the usual score of this recording, not that of the last bad frame.
  reference_ncc_ += 0.05 * (sighting.ncc - reference_ncc_);
  if (options_.rotation) {
    sighting.pose.theta = unwrapped(sighting.pose.theta, index);
    angles_.emplace_back(index, sighting.pose.theta);
    if (angles_.size() > 2) angles_.erase(angles_.begin());
  }
}

std::optional<Sighting> PatternFollower::refine(const Rect& window, const Pose& start, double max_distance) {
  const Registration r = registration_.refine(picture_, window.x, window.y, start);
  if (!r.converged || r.gain < 0.3 || r.gain > 3) return std::nullopt;
  if (r.ncc < std::max(options_.min_ncc, kNccDrop * reference_ncc_)) return std::nullopt;
  if (std::hypot(r.pose.dx - start.dx, r.pose.dy - start.dy) > max_distance) return std::nullopt;
  Sighting s{r, {pattern_.centre.x + r.pose.dx, pattern_.centre.y + r.pose.dy}};
  if (audited_) s.halves = registration_.halves();
  return s;
}

/// From the predicted angle; where the texture has turned too far for that, from the best of all angles.
std::optional<Sighting> PatternFollower::refine_any_angle(const Rect& window, const Pose& start,
                                                          double max_distance) {
  auto best = refine(window, start, max_distance);
  if (!options_.rotation || (best && best->ncc > 0.97 * reference_ncc_)) return best;
  Pose turned = start;
  double top = -1;
  for (int k = 0; k < kAngles; ++k) {
    Pose trial = start;
    trial.theta += 2 * std::numbers::pi * k / kAngles;
    const double score = registration_.score(picture_, window.x, window.y, trial);
    if (score > top) {
      top = score;
      turned = trial;
    }
  }
  auto other = refine(window, turned, max_distance);
  return other && (!best || other->ncc > best->ncc + 0.01) ? other : best;
}

std::optional<Sighting> PatternFollower::near(FrameSource& source, std::int64_t index, const Point& predicted,
                                              double reach) {
  const Rect bounds = source.bounds();
  const int margin = static_cast<int>(std::ceil(reach)) + 2;
  const int shift_x = static_cast<int>(std::lround(predicted.x - pattern_.centre.x));
  const int shift_y = static_cast<int>(std::lround(predicted.y - pattern_.centre.y));
  const Rect& w = pattern_.window;
  const Rect window = grown({w.x + shift_x, w.y + shift_y, w.width, w.height}, margin, bounds);
  if (window.width < w.width / 2 || window.height < w.height / 2) return std::nullopt;
  source.read(index, window, picture_);

  const auto within = [&](std::optional<Sighting> s) {
    if (s && !pattern_.inside(bounds, s->position, kEdgeMargin)) {
      outside_ = s;
      s.reset();
    }
    return s;
  };
  const auto itself = [&](std::optional<Sighting> s) {
    if (!s || distance(s->position, predicted) <= own_radius() || !may_be_another(source, index, s->position))
      return within(s);
    if (!s->by_rim) ended_ = index;  // a rim alone is not enough of a likeness to end a track by
    return std::optional<Sighting>();
  };
  if (rim_ && template_rest_ > 0)
    if (auto s = by_rim(window, index, predicted, reach)) return itself(s);
  Point place = predicted;
  if (auto s = by_template(window, index, predicted, reach, place)) return itself(s);
  return rim_ ? itself(by_rim(window, index, place, reach)) : std::nullopt;
}

/// `place` becomes that of the best correlation, where the prediction is not confirmed.
std::optional<Sighting> PatternFollower::by_template(const Rect& window, std::int64_t index,
                                                     const Point& predicted, double reach, Point& place) {
  const Pose start = pose_at(predicted, index);
  if (auto s = refine(window, start, reach); s && s->ncc > 0.95 * reference_ncc_) return s;
  const std::vector<Point> best = matches(window, pattern_.reach(), 1);
  if (best.empty()) return refine(window, start, reach);  // perhaps half out of the picture
  place = best.front();
  return refine_any_angle(window, pose_at(place, index), kCandidateReach);
}

/// Where the search template fits in the window, best first; whole positions only.
std::vector<Point> PatternFollower::matches(const Rect& window, double separation, int most) const {
  std::vector<Point> out;
  for (const Match& m : matcher_.search(picture_, 0.7 * search_reference_, separation, most))
    out.push_back({window.x + m.x + (pattern_.centre.x - pattern_.window.x),
                   window.y + m.y + (pattern_.centre.y - pattern_.window.y)});
  return out;
}

/// Nothing but the rim of the same part will do.
std::optional<Sighting> PatternFollower::by_rim(const Rect& window, std::int64_t index, const Point& place,
                                                double reach) {
  const auto rim =
      measure_rim_sectors(picture_, {place.x - window.x, place.y - window.y, rim_->radius}, rim_->blur);
  if (!rim || !same_rim(*rim, *rim_) || rim->correlation < options_.min_ncc) return std::nullopt;
  const Point centre{window.x + rim->circle.x + rim_->offset.x, window.y + rim->circle.y + rim_->offset.y};
  if (distance(centre, place) > reach) return std::nullopt;
  Sighting s;
  s.position = centre;
  s.covariance = rim->covariance;
  s.pose = pose_at(centre, index);
  s.ncc = rim->correlation;
  s.residual_rms = rim->residual_rms;
  s.by_rim = true;
  return s;
}

/// In the whole frame, which is in `picture_`.
std::vector<Point> PatternFollower::candidates() {
  return matches(bounds_of(picture_), 0.8 * pattern_.reach(), kMostAlike);
}

/// What else looked like the part when the part was last seen.
void PatternFollower::remember_distractors(FrameSource& source) {
  distractors_.clear();
  source.read(motion_.last_frame(), source.bounds(), picture_);
  fruitless_ = Picture();
  for (const Point& c : candidates())
    if (distance(c, motion_.last()) > 0.6 * pattern_.reach()) distractors_.add(c);
  distractors_known_ = true;
}

/// Two of the kind lie at least twice this apart: within it of its prediction the part is itself.
double PatternFollower::own_radius() const {
  return pattern_.radius > 0 ? pattern_.radius
                             : 0.5 * std::min(pattern_.window.width, pattern_.window.height);
}

/// Whether something that looked like the part when the part was last seen is nearly as likely to have come
/// to a place: by less than twice the way, from where it was or from where the part's motion would take it.
/// What is still where it was has not.
bool PatternFollower::may_be_another(FrameSource& source, std::int64_t index, const Point& place) {
  Picture window = std::move(picture_);
  remember_distractors(source);
  source.read(index, source.bounds(), picture_);
  const std::vector<Point> now = candidates();
  picture_ = std::move(window);
  distractors_known_ = false;
  const Point predicted = motion_.at(index), last = motion_.last();
  const double way = distance(place, predicted);
  const auto still_at = [&](const Point& other) {
    return distance(place, other) > own_radius() &&
           std::ranges::any_of(now, [&](const Point& c) { return distance(c, other) < own_radius(); });
  };
  return std::ranges::any_of(distractors_.places(), [&](const Point& other) {
    const Point carried{other.x + predicted.x - last.x, other.y + predicted.y - last.y};
    return std::min(distance(place, other), distance(place, carried)) < 2 * way && !still_at(other) &&
           !still_at(carried);
  });
}

/// By its template, or by its rim where that was last seen alone.
std::optional<Sighting> PatternFollower::found_again(const Rect& bounds, std::int64_t index,
                                                     const Point& place) {
  auto s = refine_any_angle(bounds, pose_at(place, index), kCandidateReach);
  if (s && s->ncc < kRefoundNccDrop * reference_ncc_) s.reset();
  if (!s && rim_ && template_pause_ > 0) s = by_rim(bounds, index, place, kCandidateReach);
  return s;
}

/// What comes back into the picture changes it by the part's contrast over the part's area: whether a share
/// of that has changed since the last search that found nothing. `picture_` is the whole frame.
bool PatternFollower::may_be_back() const {
  if (fruitless_.empty()) return true;
  const auto step = static_cast<float>(kChangedContrast * registration_.contrast());
  double changed = 0;
  for (std::size_t k = 0; k < fruitless_.levels().size(); ++k)
    changed += std::abs(picture_.levels()[k] - fruitless_.levels()[k]) > step;
  return changed > kChangedArea * registration_.area();
}

std::optional<Sighting> PatternFollower::search(FrameSource& source, std::int64_t index) {
  if (!distractors_known_) remember_distractors(source);
  const Rect bounds = source.bounds();
  source.read(index, bounds, picture_);
  if (state_ == State::left && !may_be_back()) return std::nullopt;
  const std::vector<Point> unexplained = distractors_.unexplained(candidates());
  std::vector<Sighting> found;
  const auto gap = static_cast<double>(index - motion_.last_frame());
  const double reachable = std::max(64.0, 2 * pattern_.reach()) + 2 * motion_.top_speed() * gap;
  // What has left the picture comes back through its border.
  const double band = kEdgeMargin + std::max(pattern_.reach(), 2 * motion_.top_speed());
  for (const Point& c : unexplained) {
    const bool possible =
        distance(c, motion_.at(index)) <= reachable || distance(c, motion_.last()) <= reachable;
    const bool entered = state_ != State::left || !pattern_.inside(bounds, c, band);
    std::optional<Sighting> s;
    if (possible && entered) s = found_again(bounds, index, c);
    if (s && !pattern_.inside(bounds, s->position, kEdgeMargin)) s.reset();
    if (!s) {
      if (!(possible && entered)) distractors_.add(c);
      continue;
    }
    found.push_back(*s);
  }
  fruitless_ = found.empty() ? picture_ : Picture();
  if (found.empty()) return std::nullopt;
  const Sighting best = *std::ranges::max_element(found, {}, &Sighting::ncc);
  const bool others = std::ranges::any_of(found, [&](const Sighting& s) {
    return s.ncc > best.ncc - kSameLook && distance(s.position, best.position) > own_radius();
  });
  if (others || distractors_.all_moved()) {
    ended_ = index;
    return std::nullopt;
  }
  return best;
}

}  // namespace tribotrack::vision
