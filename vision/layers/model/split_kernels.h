// The arithmetic of splitting a disc's picture into what turns and what stands (split.h), compiled
// for several instruction sets and chosen at run time.
#pragma once

#include <cstddef>
#include <vector>

namespace tribotrack::vision {

/// Neighbouring pixels of a row of one turned picture. Pixel i lies at (x + i c, y + i s) of the turning
/// picture, whose coefficients' rows are `stride` apart.
struct SplitRow {
  const float* origin = nullptr;  ///< the coefficient of pixel (0, 0)
  float* sums = nullptr;          ///< its sum
  std::ptrdiff_t stride = 0;
  float x = 0, y = 0, c = 1, s = 0;
  const float *cover = nullptr, *weight = nullptr, *given = nullptr;
  float* standing = nullptr;  ///< sums of the pixels themselves
  int count = 0;
};

struct SplitKernels {
  const char* name;
  /// g = weight (given + cover T), T the turning picture at the pixel where it is `turning`, else 0: g is
  /// added to `standing` and, times cover, to the sums of the six by six coefficients in proportion to their
  /// shares in T. Two more of a row are read, and added nothing.
  void (*add)(const SplitRow& row, bool turning);
};

/// The fastest this processor can run.
const SplitKernels& split_kernels();
/// All it can run, slowest first: what tests compare.
std::vector<SplitKernels> all_split_kernels();

}  // namespace tribotrack::vision
