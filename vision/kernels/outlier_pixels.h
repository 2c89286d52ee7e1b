// Outlier pixels: an object that covers the part also covers half of what lies beside the pixels it fills,
// where the optics blur its edge.
#pragma once

#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "vision/kernels/informative_pixels.h"
#include "vision/kernels/tile_kernels.h"

namespace tribotrack::vision {

/// Whether any of a tile's row is not 0.
inline bool any_in_row(const unsigned char* row) {
  std::uint64_t all;
  static_assert(sizeof all == kTile);
  std::memcpy(&all, row, sizeof all);
  return all != 0;
}

/// `outliers` holds one value per pixel of the tiles, not 0 where the picture shows something else. Where
/// such pixels lie together (an outlier with two more among its eight neighbours) all within `reach` px of
/// them become outliers as well; one alone is a speck, or noise. Returns how many there are then.
std::size_t spread_outliers(std::span<const TilePlace> places, double reach,
                            std::vector<unsigned char>& outliers);

}  // namespace tribotrack::vision
