#include "vision/layers/model/static_illumination.h"

#include <algorithm>
#include <cmath>

namespace tribotrack::vision {
namespace {
constexpr float kClipped = 0.5F;  ///< grey levels by which the light may change a clipped pixel
}

StaticIllumination::StaticIllumination(const Rect& region, double top)
    : region_(region),
      top_(static_cast<float>(top)),
      gain_(region.width, region.height, 1),
      offset_(region.width, region.height),
      hidden_(region.width, region.height) {}

/// act(level, place in the region's pictures) for every pixel of a window that lies in the region.
template <class Act>
void StaticIllumination::each(Picture& picture, int x, int y, const Act& act) const {
  if (empty()) return;
  const int first = std::max(x, region_.x), last = std::min(x + picture.width(), region_.x + region_.width);
  for (int row = std::max(y, region_.y); row < std::min(y + picture.height(), region_.y + region_.height);
       ++row)
    for (int column = first; column < last; ++column)
      act(picture.at(column - x, row - y),
          static_cast<std::size_t>(row - region_.y) * static_cast<std::size_t>(region_.width) +
              static_cast<std::size_t>(column - region_.x));
}

void StaticIllumination::take_out(Picture& picture, int x, int y, bool mark_unseen) const {
  const auto gain = gain_.levels(), offset = offset_.levels(), hidden = hidden_.levels();
  each(picture, x, y, [&](float& level, std::size_t at) {
    const float seen = level;
    level = (seen - offset[at]) / gain[at];
    const bool clipped = seen >= top_ && std::abs(level - seen) > kClipped;
    if (mark_unseen && (clipped || hidden[at] > 0)) level = kUnseen;
  });
}

void StaticIllumination::put_in(Picture& picture, int x, int y) const {
  const auto gain = gain_.levels(), offset = offset_.levels();
  each(picture, x, y, [&](float& level, std::size_t at) { level = gain[at] * level + offset[at]; });
}

}  // namespace tribotrack::vision
