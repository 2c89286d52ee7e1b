// The picture of ground at rest when something crosses it: a tool, a hand, the edge of a shadow.
#pragma once

#include <vector>

#include "vision/picture.h"

namespace tribotrack::vision {

/// What a place shows in most of the frames, each brought to the light of the first.
class UsualGround {
 public:
  explicit UsualGround(const Rect& region) : region_(region) {}
  /// `picture` of the whole region; what lies in `hidden` is not the ground.
  void add(Picture picture, const Circle& hidden);
  /// Median over the frames, place by place; a place never uncovered has the median of all.
  Picture median() const;

 private:
  Rect region_;
  std::vector<Picture> pictures_;
  std::vector<Circle> hidden_;
};

}  // namespace tribotrack::vision
