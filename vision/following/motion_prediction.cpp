#include "vision/following/motion_prediction.h"

#include <algorithm>
#include <cmath>

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

}  // namespace tribotrack::vision
