#include "vision/following/distractors.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tribotrack::vision {

std::vector<Point> Distractors::unexplained(const std::vector<Point>& candidates) {
  struct Pair {
    double distance;
    std::size_t place, candidate;
  };
  std::vector<Pair> pairs;
  for (std::size_t i = 0; i < places_.size(); ++i)
    for (std::size_t j = 0; j < candidates.size(); ++j) {
      const double d = std::hypot(places_[i].x - candidates[j].x, places_[i].y - candidates[j].y);
      if (d <= reach_) pairs.push_back({d, i, j});
    }
  std::sort(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) { return a.distance < b.distance; });
  const std::vector<Point> before = places_;
  const auto spacing = [&](std::size_t i) {
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t j = 0; j < before.size(); ++j)
      if (j != i)
        nearest = std::min(nearest, std::hypot(before[i].x - before[j].x, before[i].y - before[j].y));
    return nearest;
  };
  std::size_t found = 0, moved = 0;
  std::vector<bool> place_taken(places_.size());
  std::vector<bool> explained(candidates.size());
  for (const Pair& pair : pairs) {
    if (place_taken[pair.place] || explained[pair.candidate]) continue;
    place_taken[pair.place] = explained[pair.candidate] = true;
    places_[pair.place] = candidates[pair.candidate];
    ++found;
    moved += pair.distance > 0.25 * spacing(pair.place);
  }
  all_moved_ = moved >= 2 && 2 * moved > found;
  std::vector<Point> left;
  for (std::size_t j = 0; j < candidates.size(); ++j)
    if (!explained[j]) left.push_back(candidates[j]);
  return left;
}

}  // namespace tribotrack::vision
