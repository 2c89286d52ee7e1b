// The six weights of a quintic B-spline in one vector, for places that each have a fraction of their own.
#pragma once

#include <cstddef>

#include "vision/kernels/vector_kernels.h"

namespace tribotrack::vision {

using TapLanes = VectorOf<float, 8>::type;  ///< weights of the coefficients -2 .. 3, then two zeros

TRIBOTRACK_KERNEL float whole_below(float x) {
  const auto cut = static_cast<float>(static_cast<int>(x));
  return cut > x ? cut - 1 : cut;
}

/// b(t - k), t in [0, 1), each a polynomial of t: all six at once by Horner's rule.
TRIBOTRACK_KERNEL void quintic_lanes(float t, TapLanes& weight) {
  constexpr float u = 1.0F / 120;
  constexpr TapLanes c5 = {-u, 5 * u, -10 * u, 10 * u, -5 * u, u, 0, 0};
  constexpr TapLanes c4 = {5 * u, -20 * u, 30 * u, -20 * u, 5 * u, 0, 0, 0};
  constexpr TapLanes c3 = {-10 * u, 20 * u, 0, -20 * u, 10 * u, 0, 0, 0};
  constexpr TapLanes c2 = {10 * u, 20 * u, -60 * u, 20 * u, 10 * u, 0, 0, 0};
  constexpr TapLanes c1 = {-5 * u, -50 * u, 0, 50 * u, 5 * u, 0, 0, 0};
  constexpr TapLanes c0 = {u, 26 * u, 66 * u, 26 * u, u, 0, 0, 0};
  weight = ((((c5 * t + c4) * t + c3) * t + c2) * t + c1) * t + c0;
}

/// Their derivatives with respect to t.
TRIBOTRACK_KERNEL void quintic_slope_lanes(float t, TapLanes& slope) {
  constexpr float u = 1.0F / 24;
  constexpr TapLanes c4 = {-u, 5 * u, -10 * u, 10 * u, -5 * u, u, 0, 0};
  constexpr TapLanes c3 = {4 * u, -16 * u, 24 * u, -16 * u, 4 * u, 0, 0, 0};
  constexpr TapLanes c2 = {-6 * u, 12 * u, 0, -12 * u, 6 * u, 0, 0, 0};
  constexpr TapLanes c1 = {4 * u, 8 * u, -24 * u, 8 * u, 4 * u, 0, 0, 0};
  constexpr TapLanes c0 = {-u, -10 * u, 0, 10 * u, u, 0, 0, 0};
  slope = (((c4 * t + c3) * t + c2) * t + c1) * t + c0;
}

/// sum_ij y_j x_i c_ij over the six by six coefficients whose first is at `c`; eight of a row are read.
TRIBOTRACK_KERNEL void weigh_rows(const float* c, std::ptrdiff_t stride, const TapLanes& weight_y,
                                  TapLanes& columns) {
  columns = TapLanes{};
  for (int j = 0; j < 6; ++j) {
    TapLanes row;
    load(c + j * stride, row);
    columns += weight_y[j] * row;
  }
}

TRIBOTRACK_KERNEL float sum_of_lanes(const TapLanes& v) {
  return ((v[0] + v[4]) + (v[1] + v[5])) + (v[2] + v[3]);
}

}  // namespace tribotrack::vision
