#include "vision/layered_ground.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace tribotrack::vision {
namespace {

constexpr int kFramesNeeded = 3;  ///< fewer do not make a picture worth the name
constexpr int kFillRings = 8;     ///< px of smooth continuation into what was never seen

/// Unknown pixels next to known ones take their mean; repeated, so that the spline does not ring.
void continue_smoothly(Picture& levels, Picture known) {
  double sum = 0;
  double count = 0;
  for (std::size_t i = 0; i < levels.levels().size(); ++i) {
    sum += known.levels()[i] * levels.levels()[i];
    count += known.levels()[i];
  }
  const auto mean = static_cast<float>(count > 0 ? sum / count : 0);
  for (std::size_t i = 0; i < levels.levels().size(); ++i)
    if (known.levels()[i] == 0) levels.levels()[i] = mean;
  for (int ring = 0; ring < kFillRings; ++ring) {
    const Picture before = known;
    for (int y = 0; y < levels.height(); ++y)
      for (int x = 0; x < levels.width(); ++x) {
        if (before.at(x, y) > 0) continue;
        float near = 0;
        float seen = 0;
        for (int v = std::max(0, y - 1); v <= std::min(levels.height() - 1, y + 1); ++v)
          for (int u = std::max(0, x - 1); u <= std::min(levels.width() - 1, x + 1); ++u) {
            near += before.at(u, v) * levels.at(u, v);
            seen += before.at(u, v);
          }
        if (seen == 0) continue;
        levels.at(x, y) = near / seen;
        known.at(x, y) = 1;
      }
  }
}

}  // namespace

GroundPicture::GroundPicture(const Rect& region)
    : region_(region),
      sum_(region.width, region.height),
      squares_(region.width, region.height),
      count_(region.width, region.height),
      known_(region.width, region.height) {}

void GroundPicture::add(const Picture& picture, int x, int y, const Point& displacement,
                        const Circle& hidden) {
  // Places u of the platform with u + p inside the window.
  const int u0 = std::max(region_.x, static_cast<int>(std::ceil(x - displacement.x)));
  const int v0 = std::max(region_.y, static_cast<int>(std::ceil(y - displacement.y)));
  const int u1 = std::min(region_.x + region_.width - 1,
                          static_cast<int>(std::floor(x + picture.width() - 1 - displacement.x)));
  const int v1 = std::min(region_.y + region_.height - 1,
                          static_cast<int>(std::floor(y + picture.height() - 1 - displacement.y)));
  if (u1 < u0 || v1 < v0) return;
  const int width = u1 - u0 + 1;
  const int height = v1 - v0 + 1;
  Picture moved(width, height);
  QuinticSpline(picture).sample_window(u0 + displacement.x - x, v0 + displacement.y - y, width, height,
                                       moved.levels().data(), nullptr, nullptr);
  const double reach = hidden.radius * hidden.radius;
  const auto uncovered = [&](int u, int v) {
    const double dx = u + displacement.x - hidden.x;
    const double dy = v + displacement.y - hidden.y;
    return dx * dx + dy * dy > reach;
  };
  double here = 0;
  double before = 0;
  for (int v = v0; v <= v1; ++v)
    for (int u = u0; u <= u1; ++u) {
      const float n = count_.at(u - region_.x, v - region_.y);
      if (n == 0 || !uncovered(u, v)) continue;
      here += moved.at(u - u0, v - v0);
      before += sum_.at(u - region_.x, v - region_.y) / n;
    }
  const auto light = static_cast<float>(here > 0 && before > 0 ? before / here : 1);
  for (int v = v0; v <= v1; ++v)
    for (int u = u0; u <= u1; ++u) {
      if (!uncovered(u, v)) continue;
      const float level = light * moved.at(u - u0, v - v0);
      sum_.at(u - region_.x, v - region_.y) += level;
      squares_.at(u - region_.x, v - region_.y) += level * level;
      count_.at(u - region_.x, v - region_.y) += 1;
    }
}

void GroundPicture::finish() {
  Picture enough(region_.width, region_.height);
  std::vector<float> variances;
  double sum = 0;
  for (std::size_t i = 0; i < sum_.levels().size(); ++i) {
    const double n = count_.levels()[i];
    if (n >= kFramesNeeded) {
      const double mean = sum_.levels()[i] / n;
      variances.push_back(static_cast<float>((squares_.levels()[i] / n - mean * mean) * n / (n - 1)));
      sum += mean;
    }
    enough.levels()[i] = count_.levels()[i] >= kFramesNeeded ? 1.0F : 0.0F;
    sum_.levels()[i] = enough.levels()[i] > 0 ? sum_.levels()[i] / count_.levels()[i] : 0.0F;
  }
  if (!variances.empty()) {
    mean_ = sum / static_cast<double>(variances.size());
    const auto middle = variances.begin() + static_cast<std::ptrdiff_t>(variances.size() / 2);
    std::nth_element(variances.begin(), middle, variances.end());
    unrest_ = *middle;
  }
  continue_smoothly(sum_, enough);
  // A place is known where its neighbours, which the interpolation leans on, are known too.
  for (int y = 0; y < region_.height; ++y)
    for (int x = 0; x < region_.width; ++x) {
      float least = 1;
      for (int v = std::max(0, y - 1); v <= std::min(region_.height - 1, y + 1); ++v)
        for (int u = std::max(0, x - 1); u <= std::min(region_.width - 1, x + 1); ++u)
          least = std::min(least, enough.at(u, v));
      known_.at(x, y) = least;
    }
  spline_ = QuinticSpline(sum_);
  sum_ = Picture();
  count_ = Picture();
  squares_ = Picture();
}

void GroundPicture::sample(double x0, double y0, int width, int height, float* value, float* known) const {
  const double left = x0 - region_.x;
  const double top = y0 - region_.y;
  const int near_x = static_cast<int>(std::lround(left));
  const int near_y = static_cast<int>(std::lround(top));
  const bool inside = near_x >= -4 && near_y >= -4 && near_x + width <= region_.width + 4 &&
                      near_y + height <= region_.height + 4;
  if (inside) {
    spline_.sample_window(left, top, width, height, value, nullptr, nullptr);
  } else {
    for (int j = 0; j < height; ++j)
      for (int i = 0; i < width; ++i)
        value[j * width + i] = static_cast<float>(spline_.value(left + i, top + j));
  }
  for (int j = 0; j < height; ++j)
    for (int i = 0; i < width; ++i) {
      const int x = near_x + i;
      const int y = near_y + j;
      known[j * width + i] =
          x >= 0 && y >= 0 && x < region_.width && y < region_.height ? known_.at(x, y) : 0.0F;
    }
}

}  // namespace tribotrack::vision
