#include "vision/layers/model/median_ground.h"

#include <algorithm>
#include <cmath>

#include "vision/kernels/median.h"

namespace tribotrack::vision {

void UsualGround::add(Picture picture, const Circle& hidden) {
  pictures_.push_back(std::move(picture));
  hidden_.push_back(hidden);
}

Picture UsualGround::median() const {
  const auto uncovered = [&](std::size_t k, int x, int y) {
    const Circle& c = hidden_[k];
    return std::hypot(region_.x + x - c.x, region_.y + y - c.y) > c.radius;
  };
  // The light of a frame: what most places say.
  std::vector<float> light, levels;
  for (std::size_t k = 0; k < pictures_.size(); ++k) {
    levels.clear();
    for (int y = 0; y < region_.height; y += 3)
      for (int x = 0; x < region_.width; x += 3)
        if (uncovered(k, x, y) && uncovered(0, x, y) && pictures_[k].at(x, y) > 0)
          levels.push_back(pictures_[0].at(x, y) / pictures_[k].at(x, y));
    light.push_back(levels.empty() ? 1 : vision::median(levels));
  }
  Picture out(region_.width, region_.height);
  std::vector<float> all;
  std::vector<std::size_t> never;
  for (int y = 0; y < region_.height; ++y)
    for (int x = 0; x < region_.width; ++x) {
      levels.clear();
      for (std::size_t k = 0; k < pictures_.size(); ++k)
        if (uncovered(k, x, y)) levels.push_back(light[k] * pictures_[k].at(x, y));
      if (levels.empty()) {
        never.push_back(static_cast<std::size_t>(y) * static_cast<std::size_t>(region_.width) +
                        static_cast<std::size_t>(x));
        continue;
      }
      out.at(x, y) = vision::median(levels);
      all.push_back(out.at(x, y));
    }
  const float usual = vision::median(all);
  for (const std::size_t at : never) out.levels()[at] = usual;
  return out;
}

}  // namespace tribotrack::vision
