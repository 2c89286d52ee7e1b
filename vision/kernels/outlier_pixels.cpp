#include "vision/kernels/outlier_pixels.h"

#include <algorithm>
#include <cmath>

namespace tribotrack::vision {
namespace {

constexpr unsigned char kOutlier = 1, kNearby = 2;

}  // namespace

std::size_t spread_outliers(std::span<const TilePlace> places, double reach,
                            std::vector<unsigned char>& outliers) {
  if (places.empty()) return 0;
  const int margin = std::max(1, static_cast<int>(reach));
  const auto columns = std::ranges::minmax(places, {}, &TilePlace::x);
  const auto rows = std::ranges::minmax(places, {}, &TilePlace::y);
  const int left = columns.min.x, top = rows.min.y;
  const int width = columns.max.x - left + kTile + 2 * margin, height = rows.max.y - top + kTile + 2 * margin;
  std::vector<unsigned char> map(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  // Row j of a tile: its first pixel in the map.
  const auto row_of = [&](const TilePlace& place, int j) {
    return static_cast<std::ptrdiff_t>(place.y - top + margin + j) * width + (place.x - left + margin);
  };
  std::vector<std::ptrdiff_t> seen;
  for (std::size_t t = 0; t < places.size(); ++t)
    for (int j = 0; j < kTile; ++j) {
      const unsigned char* row = outliers.data() + t * kTilePixels + static_cast<std::size_t>(j) * kTile;
      if (!any_in_row(row)) continue;
      for (int i = 0; i < kTile; ++i)
        if (row[i] != 0) {
          seen.push_back(row_of(places[t], j) + i);
          map[static_cast<std::size_t>(seen.back())] = kOutlier;
        }
    }
  for (const std::ptrdiff_t p : seen) {
    int together = -1;
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx)
        together += map[static_cast<std::size_t>(p + dy * width + dx)] & kOutlier;
    if (together < 2) continue;
    for (int dy = -margin; dy <= margin; ++dy)
      for (int dx = -margin; dx <= margin; ++dx)
        if (dx * dx + dy * dy <= reach * reach) map[static_cast<std::size_t>(p + dy * width + dx)] |= kNearby;
  }
  std::size_t count = 0;
  for (std::size_t t = 0; t < places.size(); ++t)
    for (int j = 0; j < kTile; ++j) {
      unsigned char* row = outliers.data() + t * kTilePixels + static_cast<std::size_t>(j) * kTile;
      const unsigned char* from = map.data() + row_of(places[t], j);
      if (!any_in_row(from)) continue;
      for (int i = 0; i < kTile; ++i) {
        row[i] = from[i] != 0;
        count += row[i];
      }
    }
  return count;
}

}  // namespace tribotrack::vision
