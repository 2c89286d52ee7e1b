// Keeping track of things that look like the part but are not, so that a lost part is not mistaken for one of
// them.
#pragma once

#include <vector>

#include "vision/picture.h"

namespace tribotrack::vision {

/// Positions of look-alikes, carried from frame to frame by nearest neighbour.
class LookAlikes {
 public:
  /// `reach`: how far a look-alike may be from where it was last seen, px.
  explicit LookAlikes(double reach) : reach_(reach) {}
  void clear() { places_.clear(); }
  void add(const Point& place) { places_.push_back(place); }
  const std::vector<Point>& places() const { return places_; }

  /// Takes the candidates of a new frame, gives each known look-alike the nearest one within reach (nearest
  /// pairs first, one each), and returns those that are left: things not seen before. A look-alike that is
  /// not seen (a hand covers it) keeps its place.
  std::vector<Point> unexplained(const std::vector<Point>& candidates);

 private:
  double reach_;
  std::vector<Point> places_;
};

}  // namespace tribotrack::vision
