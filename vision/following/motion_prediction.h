// Where a followed thing should be next.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>

#include "vision/picture.h"

namespace tribotrack::vision {

/// Constant velocity through the last two positions, and how well that has worked.
class MotionPrediction {
 public:
  void add(std::int64_t frame, const Point& position);
  bool empty() const { return places_.empty(); }
  std::int64_t last_frame() const { return places_.back().frame; }
  Point last() const { return places_.back().position; }
  Point at(std::int64_t frame) const;
  /// How far from the prediction the thing may be, px: three times the recent rms error of prediction, grown
  /// with the number of frames since it was last seen.
  double reach(std::int64_t frame) const;
  /// Largest speed seen, px per frame.
  double top_speed() const { return top_speed_; }
  /// Present speed, px per frame.
  double speed() const;

 private:
  struct Place {
    std::int64_t frame = 0;
    Point position;
  };
  std::deque<Place> places_;
  double error_squared_ = 4;  ///< running mean, px^2; starts as ignorance
  double top_speed_ = 0;
};

}  // namespace tribotrack::vision
