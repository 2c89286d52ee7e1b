// What two halves of a frame say about its position.
#pragma once

#include <Eigen/Core>

#include "vision/picture.h"

namespace tribotrack::vision {

/// Sums over one tile of 8 x 8 pixels at the optimum of a registered frame; parameters: x, y, then nuisances.
struct TileSums {
  using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, 8, 1>;
  using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, 8, 8>;
  Point place;    ///< the tile's middle, px from the part's centre
  Vector score;   ///< sum w J r
  Matrix normal;  ///< sum w J J^T
};

}  // namespace tribotrack::vision
