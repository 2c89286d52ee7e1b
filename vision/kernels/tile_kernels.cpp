#include "vision/kernels/tile_kernels.h"

#include <cmath>
#include <cstdint>

#include "vision/kernels/vector_kernels.h"

namespace tribotrack::vision {
namespace {

using Lanes = VectorOf<float, kTile>::type;  // a row of a tile

TRIBOTRACK_KERNEL void sample_tiles(const std::vector<const float*>& corners, std::ptrdiff_t stride,
                                    const SplineTaps& taps, float pivot, bool slopes, TileArrays& arrays) {
  constexpr int kRows = kTile + 5;
  for (std::size_t t = 0; t < corners.size(); ++t) {
    Lanes smooth[kRows], slanted[kRows];
    for (int j = 0; j < kRows; ++j) {
      const float* c = corners[t] + (j - 2) * stride - 2;
      Lanes a{}, b{};
      for (std::size_t k = 0; k < 6; ++k) {
        Lanes v;
        load(c + k, v);
        a += taps.weight_x[k] * v;
        if (slopes) b += taps.slope_x[k] * v;
      }
      smooth[j] = a;
      slanted[j] = b;
    }
    for (int j = 0; j < kTile; ++j) {
      const std::size_t at = t * kTilePixels + static_cast<std::size_t>(j * kTile);
      Lanes value{}, x{}, y{};
      for (int k = 0; k < 6; ++k) {
        const auto i = static_cast<std::size_t>(k);
        value += taps.weight_y[i] * smooth[j + k];
        if (!slopes) continue;
        x += taps.weight_y[i] * slanted[j + k];
        y += taps.slope_y[i] * smooth[j + k];
      }
      store(value - pivot, arrays.value.data() + at);
      if (!slopes) continue;
      store(x, arrays.slope_x.data() + at);
      store(y, arrays.slope_y.data() + at);
    }
  }
}

TRIBOTRACK_KERNEL ForceSums force_of(const TileArrays& arrays, float a, float b) {
  const bool turns = !arrays.slope_theta.empty();
  Lanes fx{}, fy{}, fv{}, f1{}, ft{}, squares{}, weight{}, largest{};
  for (std::size_t i = 0; i < arrays.tiles * kTilePixels; i += kTile) {
    Lanes v, l, w, x, y;
    load(arrays.value.data() + i, v);
    load(arrays.level.data() + i, l);
    load(arrays.weight.data() + i, w);
    load(arrays.slope_x.data() + i, x);
    load(arrays.slope_y.data() + i, y);
    const Lanes r = l - a * v - b, wr = w * r;
    fx -= wr * x;
    fy -= wr * y;
    fv += wr * v;
    f1 += wr;
    if (turns) {
      Lanes s;
      load(arrays.slope_theta.data() + i, s);
      ft += wr * s;
    }
    squares += wr * r;
    weight += w;
    const Lanes size = r < 0 ? -r : r, counted = w > 0 ? size : Lanes{};
    largest = counted > largest ? counted : largest;
  }
  ForceSums out;
  out.force = {sum(fx), sum(fy), sum(fv), sum(f1), sum(ft)};
  out.squares = sum(squares);
  out.weight = sum(weight);
  for (int i = 0; i < kTile; ++i) out.largest = std::fmax(out.largest, static_cast<double>(largest[i]));
  return out;
}

template <int columns>
TRIBOTRACK_KERNEL NormalSums normal_with(const TileArrays& arrays, std::size_t tile, std::size_t end) {
  constexpr int kSums = columns * (columns + 1) / 2;
  Lanes total[kSums] = {};
  for (std::size_t i = tile * kTilePixels; i < end * kTilePixels; i += kTile) {
    Lanes w, column[columns], one = Lanes{} + 1.0F;
    load(arrays.weight.data() + i, w);
    load(arrays.slope_x.data() + i, column[0]);
    load(arrays.slope_y.data() + i, column[1]);
    load(arrays.value.data() + i, column[2]);
    column[0] = -column[0];
    column[1] = -column[1];
    column[3] = one;
    if constexpr (columns == 5) load(arrays.slope_theta.data() + i, column[4]);
    for (int c = 0, k = 0; c < columns; ++c) {
      const Lanes weighted = w * column[c];
      for (int d = c; d < columns; ++d, ++k) total[k] += weighted * column[d];
    }
  }
  NormalSums out{};
  for (int k = 0; k < kSums; ++k) out[static_cast<std::size_t>(k)] = sum(total[k]);
  return out;
}

TRIBOTRACK_KERNEL NormalSums normal_of(const TileArrays& arrays) {
  return arrays.slope_theta.empty() ? normal_with<4>(arrays, 0, arrays.tiles)
                                    : normal_with<5>(arrays, 0, arrays.tiles);
}

TRIBOTRACK_KERNEL void normals_of(const TileArrays& arrays, std::vector<NormalSums>& out) {
  for (std::size_t t = 0; t < arrays.tiles; ++t)
    out[t] = arrays.slope_theta.empty() ? normal_with<4>(arrays, t, t + 1) : normal_with<5>(arrays, t, t + 1);
}

TRIBOTRACK_KERNEL ResidualCounts residuals_of(const TileArrays& arrays, const std::vector<float>& weight,
                                              float a, float b, float small, std::vector<float>& out) {
  using Counts = VectorOf<std::int32_t, kTile>::type;
  Counts counted{}, small_ones{};
  for (std::size_t i = 0; i < arrays.tiles * kTilePixels; i += kTile) {
    Lanes v, l, w;
    load(arrays.value.data() + i, v);
    load(arrays.level.data() + i, l);
    load(weight.data() + i, w);
    const Lanes r = l - a * v - b, size = r < 0 ? -r : r;
    const auto counts = w > 0;  // -1 where true
    counted -= counts;
    small_ones -= counts & (size <= small);
    store(counts ? size : Lanes{}, out.data() + i);
  }
  ResidualCounts sums;
  for (int k = 0; k < kTile; ++k) {
    sums.counted += static_cast<std::size_t>(counted[k]);
    sums.small += static_cast<std::size_t>(small_ones[k]);
  }
  return sums;
}

TRIBOTRACK_KERNEL void mark_those(const std::vector<float>& residuals, float limit,
                                  std::vector<unsigned char>& out) {
  const float* from = residuals.data();
  unsigned char* to = out.data();
  for (std::size_t i = 0; i < residuals.size(); ++i) to[i] = from[i] > limit;
}

TRIBOTRACK_KERNEL void scores_of(const TileArrays& arrays, float a, float b,
                                 std::vector<std::array<double, 5>>& out) {
  const bool turns = !arrays.slope_theta.empty();
  for (std::size_t t = 0; t < arrays.tiles; ++t) {
    Lanes fx{}, fy{}, fv{}, f1{}, ft{};
    for (std::size_t i = t * kTilePixels; i < (t + 1) * kTilePixels; i += kTile) {
      Lanes v, l, w, x, y;
      load(arrays.value.data() + i, v);
      load(arrays.level.data() + i, l);
      load(arrays.weight.data() + i, w);
      load(arrays.slope_x.data() + i, x);
      load(arrays.slope_y.data() + i, y);
      const Lanes wr = w * (l - a * v - b);
      fx -= wr * x;
      fy -= wr * y;
      fv += wr * v;
      f1 += wr;
      if (!turns) continue;
      Lanes s;
      load(arrays.slope_theta.data() + i, s);
      ft += wr * s;
    }
    out[t] = {sum(fx), sum(fy), sum(fv), sum(f1), sum(ft)};
  }
}

TRIBOTRACK_KERNEL CorrelationSums correlation_of(const TileArrays& arrays, const std::vector<float>& weight) {
  Lanes sw{}, sv{}, sl{}, svv{}, sll{}, svl{};
  for (std::size_t i = 0; i < arrays.tiles * kTilePixels; i += kTile) {
    Lanes v, l, w;
    load(arrays.value.data() + i, v);
    load(arrays.level.data() + i, l);
    load(weight.data() + i, w);
    const Lanes wv = w * v, wl = w * l;
    sw += w;
    sv += wv;
    sl += wl;
    svv += wv * v;
    sll += wl * l;
    svl += wv * l;
  }
  return {sum(sw), sum(sv), sum(sl), sum(svv), sum(sll), sum(svl)};
}

// The same functions for each instruction set.
#define TRIBOTRACK_VARIANT(suffix, ...)                                                                     \
  __VA_ARGS__ void sample_##suffix(const std::vector<const float*>& corners, std::ptrdiff_t stride,         \
                                   const SplineTaps& taps, float pivot, bool slopes, TileArrays& arrays) {  \
    slopes ? sample_tiles(corners, stride, taps, pivot, true, arrays)                                       \
           : sample_tiles(corners, stride, taps, pivot, false, arrays);                                     \
  }                                                                                                         \
  __VA_ARGS__ ForceSums force_##suffix(const TileArrays& arrays, float a, float b) {                        \
    return force_of(arrays, a, b);                                                                          \
  }                                                                                                         \
  __VA_ARGS__ NormalSums normal_##suffix(const TileArrays& arrays) {                                        \
    return normal_of(arrays);                                                                               \
  }                                                                                                         \
  __VA_ARGS__ void normals_##suffix(const TileArrays& arrays, std::vector<NormalSums>& out) {               \
    normals_of(arrays, out);                                                                                \
  }                                                                                                         \
  __VA_ARGS__ ResidualCounts residuals_##suffix(const TileArrays& arrays, const std::vector<float>& weight, \
                                                float a, float b, float small, std::vector<float>& out) {   \
    return residuals_of(arrays, weight, a, b, small, out);                                                  \
  }                                                                                                         \
  __VA_ARGS__ void mark_##suffix(const std::vector<float>& residuals, float limit,                          \
                                 std::vector<unsigned char>& out) {                                         \
    mark_those(residuals, limit, out);                                                                      \
  }                                                                                                         \
  __VA_ARGS__ void scores_##suffix(const TileArrays& arrays, float a, float b,                              \
                                   std::vector<std::array<double, 5>>& out) {                               \
    scores_of(arrays, a, b, out);                                                                           \
  }                                                                                                         \
  __VA_ARGS__ CorrelationSums correlation_##suffix(const TileArrays& arrays, const std::vector<float>& w) { \
    return correlation_of(arrays, w);                                                                       \
  }                                                                                                         \
  constexpr TileKernels k_##suffix{#suffix,         sample_##suffix,  force_##suffix,                       \
                                   normal_##suffix, normals_##suffix, residuals_##suffix,                   \
                                   mark_##suffix,   scores_##suffix,  correlation_##suffix};

TRIBOTRACK_VARIANT(baseline)
TRIBOTRACK_VARIANT(avx2, TRIBOTRACK_AVX2)
#undef TRIBOTRACK_VARIANT

}  // namespace

std::vector<TileKernels> all_tile_kernels() {
  return runnable(k_baseline, k_avx2);
}

const TileKernels& tile_kernels() {
  static const TileKernels fastest = all_tile_kernels().back();
  return fastest;
}

}  // namespace tribotrack::vision
