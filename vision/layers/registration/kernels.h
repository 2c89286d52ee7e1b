// The arithmetic of the layered registration over tiles of 8 x 8 pixels.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "vision/kernels/tile_kernels.h"

namespace tribotrack::vision {

/// Light as it falls on the part, about a fixed pixel: gain + slope_x u + slope_y v; and on the ground, whose
/// picture holds its own slopes.
struct LayerLight {
  double gain = 1, slope_x = 0, slope_y = 0, ground = 1;
  double blend = 0;  ///< kappa, px^2
  double mean = 0;   ///< of the ground, which F holds
};

/// Pictures and frame over all tiles, 64 numbers per tile.
struct LayerArrays {
  TileArrays part, share, ground;      ///< F, alpha and G - mean G with their slopes
  std::vector<float> u, v;             ///< px from the fixed pixel
  std::vector<float> level;            ///< I
  std::vector<float> variance;         ///< V
  std::vector<float> ground_variance;  ///< of G beyond what is usual at a place, which V holds
  std::vector<float> weight;           ///< 1 / (V + (b alpha)^2 var G), 0 where a pixel does not count
  std::vector<float> step_x, step_y;   ///< dM/dc as last formed
  std::vector<float> below;            ///< what shows of the ground, as last formed or summed
  std::size_t tiles = 0;
  void resize(std::size_t count);
};

/// Columns of the Jacobian of M = (gain + slope . u) (F - alpha mean G) + ground (alpha G + kappa grad alpha
/// . grad G), in this order.
enum LayerColumn { kStepX, kStepY, kGain, kSlopeX, kSlopeY, kGround, kLayerColumns };

/// With r = I - M: sums of weight J r and weight r^2, the largest weight r^2; and, over what counts, of M and
/// I for their correlation.
struct LayerForce {
  std::array<double, kLayerColumns> force{};
  double squares = 0, largest = 0;
  CorrelationSums correlation;  ///< v is M, l is I
};

/// Sums of weight J_i J_j, i <= j, row after row of the upper triangle.
using LayerNormal = std::array<double, kLayerColumns*(kLayerColumns + 1) / 2>;

/// Sets weights (from 0 and 1 in `mask`), step_x, step_y, and returns the normal sums.
LayerNormal form_normal(LayerArrays& arrays, const std::vector<float>& mask, const LayerLight& light);
/// Over the tiles `tile` .. `end` - 1. Sets `below` to what the share now is.
LayerForce layer_force(LayerArrays& arrays, const LayerLight& light, std::size_t tile, std::size_t end);

}  // namespace tribotrack::vision
