// What covers the part covers its neighbours, too: half, where the optics blur its edge.
#pragma once

#include <span>
#include <vector>

#include "vision/informative_pixels.h"

namespace tribotrack::vision {

/// `strange` holds one value per pixel of the tiles, not 0 where what is seen is something else. Where such
/// pixels lie together (a stranger with two more among its eight neighbours) all within `reach` px of them
/// become strange as well; one alone is a speck, or noise. Returns how many are strange now.
std::size_t spread_strangers(std::span<const TilePlace> places, double reach,
                             std::vector<unsigned char>& strange);

}  // namespace tribotrack::vision
