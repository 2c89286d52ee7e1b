// The arithmetic of the layered registration over tiles of 8 x 8 pixels, compiled for several instruction
// sets and chosen at run time.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "vision/kernels/tile_kernels.h"
#include "vision/layers/model/state.h"

namespace tribotrack::vision {

/// Light as it falls on the disc, about a fixed pixel: gain + slope_x u + slope_y v; and on the ground.
struct LayerLight {
  double gain = 1, slope_x = 0, slope_y = 0, ground = 1;
  double turn = 0;   ///< rad from where the disc's picture was formed
  double blend = 0;  ///< kappa, px^2
};

/// Layers and picture over all tiles, 64 numbers per tile.
struct LayerArrays {
  TileArrays disc, share, ground;      ///< S, w, B with their slopes
  TileArrays turn;                     ///< dS/dtheta; empty where the disc does not turn
  std::vector<float> u, v;             ///< px from the fixed pixel
  std::vector<float> level;            ///< I
  std::vector<float> weight;           ///< 1 / variance, 0 where a pixel does not count
  std::vector<float> ground_variance;  ///< of B
  std::vector<float> rim;              ///< 1 on the rim, else 0
  std::vector<float> step_x, step_y;   ///< dM/dc as last formed
  std::vector<float> blended;          ///< kappa grad w . grad B as last formed
  std::size_t tiles = 0;
};

/// Columns of the Jacobian of M = (gain + slope . u) S + ground (w B + kappa grad w . grad B), in this order.
enum LayerColumn { kStepX, kStepY, kGain, kSlopeX, kSlopeY, kGround, kTurn, kLayerColumns };

/// With r = I - M: sums of weight J r, weight r^2 (all, and on the rim), the largest weight r^2; and, over
/// what counts, of I and M for their correlation.
struct LayerForce {
  std::array<double, kLayerColumns> force{};
  double squares = 0, rim_squares = 0, largest = 0;
  CorrelationSums correlation;  ///< v is M, l is I
};

/// Sums of weight J_i J_j, i <= j, row after row of the upper triangle: 21 numbers for 6 columns, 28 for 7.
using LayerNormal = std::array<double, 28>;

/// Sums over a row of the disc's even middle, where S hardly varies, with r = I - S: weight S r,
/// weight S r u, weight r^2.
struct PlateauRow {
  const float* level;
  const float* disc;
  const float* weight;
  const float* u;
  int count;
};
using PlateauSums = std::array<double, 3>;

/// On kappa and on a shift of w alone over the rim, with q = ground grad w . grad B and
/// s = -ground (B - mean B) grad w: sums of weight q r, weight q^2, weight s s' (xx, xy, yy), weight s r, and
/// weight J s for every column J (0 for a turn that is not asked for).
struct LayerRimSums {
  double qr = 0, qq = 0;
  std::array<double, 3> shift_normal{};
  std::array<double, 2> shift_force{};
  std::array<std::array<double, 2>, kLayerColumns> mixed{};
};

struct LayerKernels {
  const char* name;
  /// Sets weights (from 0 and 1 in `mask`), step_x, step_y, blended, and returns the normal sums.
  LayerNormal (*form)(LayerArrays& arrays, const std::vector<float>& mask, const LayerLight& light,
                      const NoiseLaw& noise);
  LayerForce (*force)(const LayerArrays& arrays, const LayerLight& light);
  PlateauSums (*plateau)(const PlateauRow& row);
  /// Of the pixels that count and lie on the rim; the weights are those last formed.
  LayerRimSums (*rim)(const LayerArrays& arrays, const std::vector<float>& counts, const LayerLight& light,
                      double ground_mean);
};

/// The fastest this processor can run.
const LayerKernels& layer_kernels();
/// All it can run, slowest first: what tests compare.
std::vector<LayerKernels> all_layer_kernels();

}  // namespace tribotrack::vision
