#include "vision/kernels/spline_kernels.h"

#include <algorithm>
#include <array>
#include <cstdlib>

#include "vision/kernels/quintic_lanes.h"
#include "vision/kernels/vector_kernels.h"

namespace tribotrack::vision {
namespace {

/// One sample of all signals of a panel, in vectors that fit registers: a recursion kept in memory waits for
/// it.
using Lanes = VectorOf<float, 8>::type;
constexpr int kVectors = kPanel / 8;

constexpr std::array<float, 2> kPoles = {-0.43057534709997379F, -0.04309628820326465F};
constexpr int kMemory = 28;  ///< |z|^28 < 1e-10

/// Unser, Aldroubi, Eden (1993), box 2, with whole-sample mirrors.
TRIBOTRACK_KERNEL void prefilter_panel(float* panel, int n) {
  if (n < 2) return;
  const auto sample = [&](int k, int q) { return panel + static_cast<std::ptrdiff_t>(kPanel) * k + 8 * q; };
  for (const float z : kPoles) {
    const float gain = (1 - z) * (1 - 1 / z);
    Lanes sum[kVectors] = {};
    float power = 1;
    const int period = 2 * (n - 1);
    const int reach = std::min(period, kMemory);
    for (int k = 0; k < reach; ++k, power *= z)
      for (int q = 0; q < kVectors; ++q) {
        Lanes v;
        load(sample(k < n ? k : period - k, q), v);
        sum[q] += power * v;
      }
    Lanes before[kVectors];
    for (int q = 0; q < kVectors; ++q) {
      if (reach == period) sum[q] /= 1 - power;
      before[q] = gain * sum[q];
      store(before[q], sample(0, q));
    }
    for (int k = 1; k < n; ++k)
      for (int q = 0; q < kVectors; ++q) {
        Lanes v;
        load(sample(k, q), v);
        before[q] = gain * v + z * before[q];
        store(before[q], sample(k, q));
      }
    Lanes after[kVectors];
    for (int q = 0; q < kVectors; ++q) {
      Lanes other;
      load(sample(n - 2, q), other);
      after[q] = z / (z * z - 1) * (before[q] + z * other);
      store(after[q], sample(n - 1, q));
    }
    for (int k = n - 2; k >= 0; --k)
      for (int q = 0; q < kVectors; ++q) {
        Lanes v;
        load(sample(k, q), v);
        after[q] = z * (after[q] - v);
        store(after[q], sample(k, q));
      }
  }
}

TRIBOTRACK_KERNEL void along_rows(const float* c, std::ptrdiff_t stride, const std::array<float, 6>& w,
                                  std::size_t rows, std::size_t line, float* out) {
  for (std::size_t j = 0; j < rows; ++j, c += stride, out += line)
    for (std::size_t i = 0; i < line; ++i)
      out[i] = w[0] * c[i] + w[1] * c[i + 1] + w[2] * c[i + 2] + w[3] * c[i + 3] + w[4] * c[i + 4] +
               w[5] * c[i + 5];
}

TRIBOTRACK_KERNEL void along_columns(const float* r, const std::array<float, 6>& w, std::size_t rows,
                                     std::size_t line, float* out) {
  for (std::size_t j = 0; j < rows; ++j, r += line, out += line)
    for (std::size_t i = 0; i < line; ++i)
      out[i] = w[0] * r[i] + w[1] * r[i + line] + w[2] * r[i + 2 * line] + w[3] * r[i + 3 * line] +
               w[4] * r[i + 4 * line] + w[5] * r[i + 5 * line];
}

TRIBOTRACK_KERNEL void sample_window(const float* corner, std::ptrdiff_t stride, const SplineTaps& taps,
                                     int width, int height, std::vector<float>& scratch, float* value,
                                     float* slope_x, float* slope_y) {
  const auto line = static_cast<std::size_t>(width);
  const auto lines = static_cast<std::size_t>(height);
  const std::size_t rows = lines + 5;
  if (scratch.size() < 2 * rows * line) scratch.resize(2 * rows * line);
  float* smooth = scratch.data();
  float* slanted = smooth + rows * line;
  const float* first = corner - 2 * stride - 2;
  along_rows(first, stride, taps.weight_x, rows, line, smooth);
  along_columns(smooth, taps.weight_y, lines, line, value);
  if (slope_y) along_columns(smooth, taps.slope_y, lines, line, slope_y);
  if (!slope_x) return;
  along_rows(first, stride, taps.slope_x, rows, line, slanted);
  along_columns(slanted, taps.weight_y, lines, line, slope_x);
}

TRIBOTRACK_KERNEL void sample_at(const SplinePlaces& places, float* value, float* slope_x, float* slope_y) {
  const float right = static_cast<float>(places.width) + 3.99F,
              bottom = static_cast<float>(places.height) + 3.99F;
  for (std::size_t k = 0; k < places.count; ++k) {
    const float x = std::min(std::max(places.x[k], -5.0F), right);
    const float y = std::min(std::max(places.y[k], -5.0F), bottom);
    const float fx = whole_below(x), fy = whole_below(y);
    const float* c = places.origin + (static_cast<std::ptrdiff_t>(fy) - 2) * places.stride +
                     (static_cast<std::ptrdiff_t>(fx) - 2);
    TapLanes wx, wy, columns;
    quintic_lanes(x - fx, wx);
    quintic_lanes(y - fy, wy);
    weigh_rows(c, places.stride, wy, columns);
    value[k] = sum_of_lanes(columns * wx);
    if (!slope_x) continue;
    TapLanes sx, sy, slanted;
    quintic_slope_lanes(x - fx, sx);
    quintic_slope_lanes(y - fy, sy);
    weigh_rows(c, places.stride, sy, slanted);
    slope_x[k] = sum_of_lanes(columns * sx);
    slope_y[k] = sum_of_lanes(slanted * wx);
  }
}

#define TRIBOTRACK_VARIANT(suffix, ...)                                                                    \
  __VA_ARGS__ void prefilter_##suffix(float* panel, int samples) {                                         \
    prefilter_panel(panel, samples);                                                                       \
  }                                                                                                        \
  __VA_ARGS__ void window_##suffix(const float* corner, std::ptrdiff_t stride, const SplineTaps& taps,     \
                                   int width, int height, std::vector<float>& scratch, float* value,       \
                                   float* slope_x, float* slope_y) {                                       \
    sample_window(corner, stride, taps, width, height, scratch, value, slope_x, slope_y);                  \
  }                                                                                                        \
  __VA_ARGS__ void at_##suffix(const SplinePlaces& places, float* value, float* slope_x, float* slope_y) { \
    sample_at(places, value, slope_x, slope_y);                                                            \
  }                                                                                                        \
  constexpr SplineKernels k_##suffix{#suffix, prefilter_##suffix, window_##suffix, at_##suffix};

TRIBOTRACK_VARIANT(baseline)
TRIBOTRACK_VARIANT(avx2, TRIBOTRACK_AVX2)
#undef TRIBOTRACK_VARIANT

}  // namespace

std::vector<SplineKernels> all_spline_kernels() {
  return runnable(k_baseline, k_avx2);
}

const SplineKernels& spline_kernels() {
  static const SplineKernels fastest = all_spline_kernels().back();
  return fastest;
}

}  // namespace tribotrack::vision
