#include "vision/strangers.h"

#include <algorithm>
#include <cmath>

namespace tribotrack::vision {

std::size_t spread_strangers(std::span<const TilePlace> places, double reach,
                             std::vector<unsigned char>& strange) {
  if (places.empty()) return 0;
  const int margin = std::max(1, static_cast<int>(reach));
  const auto [left, right] = std::ranges::minmax(places, {}, &TilePlace::x);
  const auto [top, bottom] = std::ranges::minmax(places, {}, &TilePlace::y);
  const int width = right.x - left.x + kTile + 2 * margin, height = bottom.y - top.y + kTile + 2 * margin;
  const auto at = [&](std::size_t k) {
    const TilePlace& place = places[k / kTilePixels];
    const int x = place.x - left.x + margin + static_cast<int>(k % kTile);
    const int y = place.y - top.y + margin + static_cast<int>(k % kTilePixels) / kTile;
    return static_cast<std::ptrdiff_t>(y) * width + x;
  };
  std::vector<unsigned char> map(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  std::vector<std::ptrdiff_t> seen;
  for (std::size_t k = 0; k < strange.size(); ++k)
    if (strange[k] != 0) {
      seen.push_back(at(k));
      map[static_cast<std::size_t>(seen.back())] = 1;
    }
  std::vector<unsigned char> spread = map;
  for (const std::ptrdiff_t p : seen) {
    int together = -1;
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx) together += map[static_cast<std::size_t>(p + dy * width + dx)];
    if (together < 2) continue;
    for (int dy = -margin; dy <= margin; ++dy)
      for (int dx = -margin; dx <= margin; ++dx)
        if (std::hypot(dx, dy) <= reach) spread[static_cast<std::size_t>(p + dy * width + dx)] = 1;
  }
  std::size_t count = 0;
  for (std::size_t k = 0; k < strange.size(); ++k) {
    strange[k] = spread[static_cast<std::size_t>(at(k))];
    count += strange[k];
  }
  return count;
}

}  // namespace tribotrack::vision
