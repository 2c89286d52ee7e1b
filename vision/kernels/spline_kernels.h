// The arithmetic of quintic splines over whole windows, compiled for several instruction sets and chosen at
// run time.
#pragma once

#include <cstddef>
#include <vector>

#include "vision/kernels/tile_kernels.h"

namespace tribotrack::vision {

inline constexpr int kPanel = 32;  ///< signals filtered side by side

/// Places of a spline that each have a fraction of their own.
struct SplinePlaces {
  const float* origin = nullptr;  ///< the coefficient of pixel (0, 0)
  std::ptrdiff_t stride = 0;
  int width = 0, height = 0;  ///< of the picture: places are clamped to 5 px before and 4 px beyond it
  const float *x = nullptr, *y = nullptr;
  std::size_t count = 0;
};

struct SplineKernels {
  const char* name;
  /// Samples to coefficients (mirrored about the first and the last sample) of kPanel signals at once, in
  /// place: panel[kPanel k + i] is sample k of signal i.
  void (*prefilter)(float* panel, int samples);
  /// out[j * width + i] for a window whose first place lies in the cell of the coefficient at `corner`; rows
  /// of coefficients are `stride` apart. Slopes may be null; `scratch` keeps its memory between calls.
  void (*window)(const float* corner, std::ptrdiff_t stride, const SplineTaps& taps, int width, int height,
                 std::vector<float>& scratch, float* value, float* slope_x, float* slope_y);
  /// Slopes may be null, both together.
  void (*at)(const SplinePlaces& places, float* value, float* slope_x, float* slope_y);
};

/// The fastest this processor can run.
const SplineKernels& spline_kernels();
/// All it can run, slowest first: what tests compare.
std::vector<SplineKernels> all_spline_kernels();

}  // namespace tribotrack::vision
