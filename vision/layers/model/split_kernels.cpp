#include "vision/layers/model/split_kernels.h"

#include "vision/kernels/quintic_lanes.h"
#include "vision/kernels/vector_kernels.h"

namespace tribotrack::vision {
namespace {

TRIBOTRACK_KERNEL void add_row(const SplitRow& row, bool turning) {
  for (int i = 0; i < row.count; ++i) {
    const float weight = row.weight[i];
    if (weight == 0) continue;
    const auto step = static_cast<float>(i);
    const float x = row.x + step * row.c, y = row.y + step * row.s;
    const float fx = whole_below(x), fy = whole_below(y);
    const std::ptrdiff_t first =
        (static_cast<std::ptrdiff_t>(fy) - 2) * row.stride + static_cast<std::ptrdiff_t>(fx) - 2;
    TapLanes wx, wy;
    quintic_lanes(x - fx, wx);
    quintic_lanes(y - fy, wy);
    float value = row.given[i];
    if (turning) {
      TapLanes columns;
      weigh_rows(row.origin + first, row.stride, wy, columns);
      value += row.cover[i] * sum_of_lanes(columns * wx);
    }
    const float g = weight * value;
    row.standing[i] += g;
    const TapLanes share = row.cover[i] * g * wx;
    float* sums = row.sums + first;
    for (int j = 0; j < 6; ++j) {
      TapLanes sum;
      load(sums + j * row.stride, sum);
      sum += wy[j] * share;
      store(sum, sums + j * row.stride);
    }
  }
}

#define TRIBOTRACK_VARIANT(suffix, ...)                              \
  __VA_ARGS__ void add_##suffix(const SplitRow& row, bool turning) { \
    add_row(row, turning);                                           \
  }                                                                  \
  constexpr SplitKernels k_##suffix{#suffix, add_##suffix};

TRIBOTRACK_VARIANT(baseline)
TRIBOTRACK_VARIANT(avx2, TRIBOTRACK_AVX2)
#undef TRIBOTRACK_VARIANT

}  // namespace

std::vector<SplitKernels> all_split_kernels() {
  return runnable(k_baseline, k_avx2);
}

const SplitKernels& split_kernels() {
  static const SplitKernels fastest = all_split_kernels().back();
  return fastest;
}

}  // namespace tribotrack::vision
