// The pixels of a template that fix its position: those whose gradient stands out of the noise.
//
// The information of a pixel is w |grad T|^2. A flat pixel adds none, but its noise looks like a gradient: it
// costs time and, where there are thousands of them, accuracy.
#pragma once

#include <span>
#include <vector>

#include "vision/kernels/tile_kernels.h"
#include "vision/picture.h"

namespace tribotrack::vision {

struct InformativeOptions {
  double share = 0.995;  ///< of the information above the noise that is kept
  /// Expectation of |grad T|^2 from the template's noise alone, grey levels^2/px^2.
  double noise_square = 0;
};

/// 1 where a pixel counts and is informative, else 0; `weights` where no pixel stands out. The gradient's
/// square is averaged over 5 x 5 px, so that what is kept moves with the template by two pixels either way.
Picture informative_pixels(const Picture& slope_x, const Picture& slope_y, const Picture& weights,
                           const InformativeOptions& options);

/// The first pixels of tiles of 8 x 8 that cover a mask.
std::vector<TilePlace> cover_with_tiles(const Picture& mask);

// Outlier pixels: an object that covers the part also covers half of what lies beside the pixels it fills,
// where the optics blur its edge.

/// `outliers` holds one value per pixel of the tiles, not 0 where the picture shows something else. Where
/// such pixels lie together (an outlier with two more among its eight neighbours) all within 3 px of them
/// become outliers as well; one alone is a speck, or noise. Returns how many there are then.
std::size_t spread_outliers(std::span<const TilePlace> places, std::vector<unsigned char>& outliers);

}  // namespace tribotrack::vision
