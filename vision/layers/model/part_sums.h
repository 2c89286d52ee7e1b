// Sums over windows at every place of the part's grid, by tiles of 8 x 8 places: those of a few tiles stay in
// the processor's cache while all windows pass by, and tiles are shared among threads.
#pragma once

#include <span>
#include <vector>

#include "vision/kernels/tile_kernels.h"
#include "vision/layers/model/ground.h"
#include "vision/layers/model/part.h"

namespace tribotrack::vision {

/// What is summed at a place, see learn_pictures(): of 1, the interpolation's share of white noise and,
/// weighted, a^2, a h, h^2, a y, h y, y^2; of q r and q^2 over the variance of r.
enum PartSum { kCount, kPassed, kAA, kAH, kHH, kAY, kHY, kYY, kQR, kQQ, kPartSums };

class PartTileSums {
 public:
  /// Keeps references.
  PartTileSums(const PartPictures& before, const GroundPicture& ground);

  /// Windows in their present states. Levels further than
  /// `trim` standard deviations from `before` are left out. The sums do not depend on the number of threads.
  void add(WindowSpan windows, double trim, int threads);

  /// A sum as a picture on the part's grid.
  Picture picture(PartSum sum) const;

 private:
  struct Workspace;
  /// Where a window's grid lies, and its light.
  struct Placed;
  Placed placed(const KeptWindow& window) const;
  void take_window(std::size_t first, std::size_t count, const KeptWindow& window, const Placed& at,
                   Workspace& work) const;
  void take_ground(std::size_t first, std::size_t count, const Placed& at, Workspace& work) const;
  void add_block(std::size_t block, const KeptWindow& window, const Placed& at, float trim, Workspace& work);
  /// The grid's values in tiles.
  std::vector<float> in_tiles(const Picture& picture) const;

  const PartPictures& before_;
  const GroundPicture& ground_;
  std::vector<TilePlace> tiles_;
  std::vector<float> u_, v_, on_grid_;  ///< px from the centre; 1 on the grid, else 0
  std::vector<float> level_, share_, variance_, share_x_, share_y_;
  std::vector<float> sums_[kPartSums];
};

}  // namespace tribotrack::vision
