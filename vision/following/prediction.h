// Where a followed thing should be next.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "vision/picture.h"

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

}  // namespace tribotrack::vision
