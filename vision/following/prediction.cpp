#include "vision/following/prediction.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tribotrack::vision {
namespace {
constexpr double kMemory = 0.2;  ///< weight of the newest error in the running mean
}

void MotionPrediction::add(std::int64_t frame, const Point& position) {
  if (!places_.empty() && places_.back().frame == frame) places_.pop_back();  // seen better
  if (!places_.empty()) {
    const Point predicted = at(frame);
    const auto gap = static_cast<double>(std::max<std::int64_t>(1, frame - last_frame()));
    const double error = std::hypot(position.x - predicted.x, position.y - predicted.y) / gap;
    error_squared_ += kMemory * (error * error - error_squared_);
    const Point from = last();
    top_speed_ = std::max(top_speed_, std::hypot(position.x - from.x, position.y - from.y) / gap);
  }
  places_.push_back({frame, position});
  if (places_.size() > 2) places_.pop_front();
}

Point MotionPrediction::at(std::int64_t frame) const {
  const Place& b = places_.back();
  if (places_.size() < 2) return b.position;
  const Place& a = places_.front();
  const double t = static_cast<double>(frame - b.frame) / static_cast<double>(b.frame - a.frame);
  return {b.position.x + t * (b.position.x - a.position.x), b.position.y + t * (b.position.y - a.position.y)};
}

double MotionPrediction::speed() const {
  if (places_.size() < 2) return 0;
  const Point next = at(last_frame() + 1);
  return std::hypot(next.x - last().x, next.y - last().y);
}

double MotionPrediction::reach(std::int64_t frame) const {
  const auto gap = static_cast<double>(std::max<std::int64_t>(1, frame - last_frame()));
  return 2 + 3 * std::sqrt(error_squared_) * gap;
}

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
