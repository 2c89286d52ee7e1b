// The arithmetic of registration over tiles of 8 x 8 pixels, in the processor's vectors. Arrays hold 64
// numbers per tile, row after row; one row of a tile is one vector.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "vision/picture.h"

namespace tribotrack::vision {

inline constexpr int kTile = 8;
inline constexpr std::size_t kTilePixels = 64;

/// A tile's first pixel.
struct TilePlace {
  int x = 0, y = 0;
};

/// Weights and slopes of the six B-spline coefficients around a place, per axis; the same for every pixel
/// when the template only moves.
struct SplineTaps {
  std::array<float, 6> weight_x{}, slope_x{}, weight_y{}, slope_y{};
};

/// The template, its derivatives and the picture over all tiles; weights are 0 where a pixel does not count.
struct TileArrays {
  std::vector<float> value, slope_x, slope_y, slope_theta;  ///< slope_theta empty without rotation
  std::vector<float> level, weight;
  std::size_t tiles = 0;
  void resize(std::size_t count);
};

/// Sums over all pixels with r = level - a value - b: of w J r for J = (-slope_x, -slope_y, value, 1,
/// slope_theta), of w r^2 and of w, and the largest |r| with w > 0.
struct ForceSums {
  std::array<double, 5> force{};
  double squares = 0, weight = 0, largest = 0;
};

/// Sums of w, w v, w l, w v^2, w l^2, w v l.
struct CorrelationSums {
  double w = 0, v = 0, l = 0, vv = 0, ll = 0, vl = 0;
  double correlation() const;  ///< 0 on flat ground
};

/// Sums of w J_i J_j, i <= j, row after row of the upper triangle: 10 numbers for 4 columns, 15 for 5.
using NormalSums = std::array<double, 15>;

inline constexpr std::size_t kAllTiles = ~std::size_t{0};
/// Value (less `pivot`) and, where slopes is set, slopes of a spline in the tiles `tile` .. `end` - 1.
/// `corners[t]` is the coefficient at the whole pixel below tile t's first place; rows are `stride` apart.
void sample_tiles(const std::vector<const float*>& corners, std::ptrdiff_t stride, const SplineTaps& taps,
                  float pivot, bool slopes, TileArrays& arrays, std::size_t tile = 0,
                  std::size_t end = kAllTiles);
/// Levels less `pivot` of the picture's pixels under tiles, whose first pixels lie (left, top) further in it;
/// beyond the picture levels and weights become 0. Whether all of them lie in it.
bool take_levels(const Picture& picture, int left, int top, const std::vector<TilePlace>& tiles, float pivot,
                 std::vector<float>& level, std::vector<float>& weight);
/// Over all tiles or `tile` .. `end` - 1, as the next; the force of a column that is not there is 0.
ForceSums force_sums(const TileArrays& arrays, float a, float b, std::size_t tile = 0,
                     std::size_t end = kAllTiles);
NormalSums normal_sums(const TileArrays& arrays, std::size_t tile = 0, std::size_t end = kAllTiles);
CorrelationSums correlation_sums(const TileArrays& arrays, const std::vector<float>& weight);

// The pixels of a template that fix its position: those whose gradient stands out of the noise.
//
// The information of a pixel is w |grad T|^2. A flat pixel adds none, but its noise looks like a gradient: it
// costs time and, where there are thousands of them, accuracy.

/// 1 where a pixel counts and is informative, else 0; `weights` where no pixel stands out. The gradient's
/// square is averaged over 5 x 5 px, so that what is kept moves with the template by two pixels either way.
/// `noise_square`: expectation of |grad T|^2 from the template's noise alone, grey levels^2/px^2.
Picture informative_pixels(const Picture& slope_x, const Picture& slope_y, const Picture& weights,
                           double noise_square);

/// The first pixels of tiles of 8 x 8 that cover a mask.
std::vector<TilePlace> cover_with_tiles(const Picture& mask);
/// What the mask holds under the tiles' pixels; 0 beyond it.
std::vector<float> under_tiles(const Picture& mask, const std::vector<TilePlace>& tiles);

// Outlier pixels: an object that covers the part also covers half of what lies beside the pixels it fills,
// where the optics blur its edge.

/// Sets the weights of outliers to 0, and says how many counted before. `outliers` holds one value per pixel
/// of the tiles, not 0 where the picture shows something else. Where such pixels lie together (an outlier
/// with two more among its eight neighbours) all within 3 px of them become outliers as well, if `spread`;
/// one alone is a speck, or noise.
std::size_t leave_out(std::span<const TilePlace> places, std::vector<unsigned char> outliers, bool spread,
                      std::span<float> weights);

}  // namespace tribotrack::vision
