#include "vision/tracking/gate_lamp.h"

#include <cmath>
#include <sstream>

namespace tribotrack::vision {
namespace {

bool in_circle(const Circle& c, int x, int y) {
  return std::hypot(x - c.x, y - c.y) <= c.radius;
}

}  // namespace

GateLamp::GateLamp(const Circle& circle, const FrameSource& source)
    : circle_(circle), top_(static_cast<float>(source.info().clipping_level())) {
  const int x0 = static_cast<int>(std::floor(circle.x - circle.radius));
  const int y0 = static_cast<int>(std::floor(circle.y - circle.radius));
  const int x1 = static_cast<int>(std::ceil(circle.x + circle.radius));
  const int y1 = static_cast<int>(std::ceil(circle.y + circle.radius));
  window_ = {x0, y0, x1 - x0 + 1, y1 - y0 + 1};
  if (!(circle.radius > 0) || !source.bounds().contains(window_)) {
    std::ostringstream text;
    text << source.info().path.string() << ": the gate's lamp at (" << circle.x << ", " << circle.y
         << ") px with radius " << circle.radius << " px is not wholly in the " << source.info().width
         << " x " << source.info().height << " picture; correct gate_px";
    throw InputError(text.str());
  }
  for (int y = 0; y < window_.height; ++y)
    for (int x = 0; x < window_.width; ++x) pixels_ += in_circle(circle_, window_.x + x, window_.y + y);
}

GateLamp::Sample GateLamp::sample(FrameSource& source, std::int64_t index) {
  source.read(index, window_, picture_);
  double sum = 0;
  int clipped = 0;
  for (int y = 0; y < window_.height; ++y)
    for (int x = 0; x < window_.width; ++x) {
      if (!in_circle(circle_, window_.x + x, window_.y + y)) continue;
      const float level = picture_.at(x, y);
      sum += level;
      clipped += level >= top_;
    }
  return {sum / pixels_, static_cast<double>(clipped) / pixels_};
}

}  // namespace tribotrack::vision
