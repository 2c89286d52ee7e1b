#include "vision/layers/registration/kernels.h"

#include <cmath>

#include "vision/kernels/vector_kernels.h"

namespace tribotrack::vision {
namespace {

using Lanes = VectorOf<float, kTile>::type;  // a row of a tile

struct FloatLight {
  float gain, slope_x, slope_y, ground, turn, blend;
  explicit FloatLight(const LayerLight& l)
      : gain(static_cast<float>(l.gain)),
        slope_x(static_cast<float>(l.slope_x)),
        slope_y(static_cast<float>(l.slope_y)),
        ground(static_cast<float>(l.ground)),
        turn(static_cast<float>(l.turn)),
        blend(static_cast<float>(l.blend)) {}
};

template <int columns>
TRIBOTRACK_KERNEL LayerNormal form_with(LayerArrays& a, const std::vector<float>& mask, const LayerLight& at,
                                        const NoiseLaw& noise) {
  constexpr int kSums = columns * (columns + 1) / 2;
  const FloatLight light(at);
  const auto n0 = static_cast<float>(noise.constant), n1 = static_cast<float>(noise.per_level);
  Lanes total[kSums] = {};
  for (std::size_t i = 0; i < a.tiles * kTilePixels; i += kTile) {
    Lanes s, sx, sy, w, wx, wy, b, bx, by, u, v, unsure, counts, st{};
    load(a.disc.value.data() + i, s);
    load(a.disc.slope_x.data() + i, sx);
    load(a.disc.slope_y.data() + i, sy);
    load(a.share.value.data() + i, w);
    load(a.share.slope_x.data() + i, wx);
    load(a.share.slope_y.data() + i, wy);
    load(a.ground.value.data() + i, b);
    load(a.ground.slope_x.data() + i, bx);
    load(a.ground.slope_y.data() + i, by);
    load(a.u.data() + i, u);
    load(a.v.data() + i, v);
    load(a.ground_variance.data() + i, unsure);
    load(mask.data() + i, counts);
    if constexpr (columns == 7) {
      load(a.turn.value.data() + i, st);
      s += light.turn * st;
    }
    const Lanes shine = light.gain + light.slope_x * u + light.slope_y * v;
    const Lanes under = light.ground * b, seen = light.ground * w;
    const Lanes blended = light.blend * (wx * bx + wy * by), below = w * b + blended;
    const Lanes model = shine * s + light.ground * below;
    const Lanes level = model > 0 ? model : Lanes{};
    const Lanes weight = counts / (n0 + n1 * level + seen * seen * unsure);
    Lanes column[columns];
    column[kStepX] = -(shine * sx + under * wx);
    column[kStepY] = -(shine * sy + under * wy);
    column[kGain] = s;
    column[kSlopeX] = u * s;
    column[kSlopeY] = v * s;
    column[kGround] = below;
    if constexpr (columns == 7) column[kTurn] = shine * st;
    store(weight, a.weight.data() + i);
    store(blended, a.blended.data() + i);
    store(column[kStepX], a.step_x.data() + i);
    store(column[kStepY], a.step_y.data() + i);
    for (int c = 0, k = 0; c < columns; ++c) {
      const Lanes weighted = weight * column[c];
      for (int d = c; d < columns; ++d, ++k) total[k] += weighted * column[d];
    }
  }
  LayerNormal out{};
  for (int k = 0; k < kSums; ++k) out[static_cast<std::size_t>(k)] = sum(total[k]);
  return out;
}

template <bool turns>
TRIBOTRACK_KERNEL LayerForce force_with(const LayerArrays& a, const LayerLight& at) {
  const FloatLight light(at);
  Lanes force[kLayerColumns] = {}, squares{}, rim_squares{}, largest{};
  Lanes n{}, sum_m{}, sum_i{}, sum_mm{}, sum_ii{}, sum_mi{};
  for (std::size_t i = 0; i < a.tiles * kTilePixels; i += kTile) {
    Lanes s, w, b, u, v, level, weight, rim, x, y, blended, st{};
    load(a.disc.value.data() + i, s);
    load(a.share.value.data() + i, w);
    load(a.ground.value.data() + i, b);
    load(a.u.data() + i, u);
    load(a.v.data() + i, v);
    load(a.level.data() + i, level);
    load(a.weight.data() + i, weight);
    load(a.rim.data() + i, rim);
    load(a.blended.data() + i, blended);
    load(a.step_x.data() + i, x);
    load(a.step_y.data() + i, y);
    if constexpr (turns) {
      load(a.turn.value.data() + i, st);
      s += light.turn * st;
    }
    const Lanes shine = light.gain + light.slope_x * u + light.slope_y * v;
    const Lanes below = w * b + blended, model = shine * s + light.ground * below;
    const Lanes r = level - model, wr = weight * r, square = wr * r;
    force[kStepX] += wr * x;
    force[kStepY] += wr * y;
    const Lanes on_disc = wr * s;
    force[kGain] += on_disc;
    force[kSlopeX] += on_disc * u;
    force[kSlopeY] += on_disc * v;
    force[kGround] += wr * below;
    if constexpr (turns) force[kTurn] += wr * shine * st;
    squares += square;
    rim_squares += square * rim;
    largest = square > largest ? square : largest;
    const Lanes counts = weight > 0 ? Lanes{} + 1.0F : Lanes{};
    const Lanes m = counts * model, l = counts * level;
    n += counts;
    sum_m += m;
    sum_i += l;
    sum_mm += m * m;
    sum_ii += l * l;
    sum_mi += m * l;
  }
  LayerForce out;
  for (std::size_t c = 0; c < kLayerColumns; ++c) out.force[c] = sum(force[c]);
  out.squares = sum(squares);
  out.rim_squares = sum(rim_squares);
  for (int i = 0; i < kTile; ++i) out.largest = std::fmax(out.largest, static_cast<double>(largest[i]));
  out.correlation = {sum(n), sum(sum_m), sum(sum_i), sum(sum_mm), sum(sum_ii), sum(sum_mi)};
  return out;
}

TRIBOTRACK_KERNEL PlateauSums plateau_of(const PlateauRow& row) {
  Lanes even{}, sloped{}, squares{};
  int i = 0;
  for (; i + kTile <= row.count; i += kTile) {
    Lanes level, disc, weight, u;
    load(row.level + i, level);
    load(row.disc + i, disc);
    load(row.weight + i, weight);
    load(row.u + i, u);
    const Lanes r = level - disc, wr = weight * r, on_disc = wr * disc;
    even += on_disc;
    sloped += on_disc * u;
    squares += wr * r;
  }
  PlateauSums out{sum(even), sum(sloped), sum(squares)};
  for (; i < row.count; ++i) {
    const float r = row.level[i] - row.disc[i], wr = row.weight[i] * r, on_disc = wr * row.disc[i];
    out[0] += static_cast<double>(on_disc);
    out[1] += static_cast<double>(on_disc * row.u[i]);
    out[2] += static_cast<double>(wr * r);
  }
  return out;
}

template <int columns>
TRIBOTRACK_KERNEL LayerRimSums rim_with(const LayerArrays& a, const std::vector<float>& counts,
                                        const LayerLight& at, double ground_mean) {
  const FloatLight light(at);
  const auto mean = static_cast<float>(ground_mean);
  Lanes qr{}, qq{}, xx{}, xy{}, yy{}, xr{}, yr{}, mixed_x[kLayerColumns] = {}, mixed_y[kLayerColumns] = {};
  for (std::size_t i = 0; i < a.tiles * kTilePixels; i += kTile) {
    Lanes s, w, wx, wy, b, bx, by, u, v, level, weight, rim, count, x, y, blended, st{};
    load(a.disc.value.data() + i, s);
    load(a.share.value.data() + i, w);
    load(a.share.slope_x.data() + i, wx);
    load(a.share.slope_y.data() + i, wy);
    load(a.ground.value.data() + i, b);
    load(a.ground.slope_x.data() + i, bx);
    load(a.ground.slope_y.data() + i, by);
    load(a.u.data() + i, u);
    load(a.v.data() + i, v);
    load(a.level.data() + i, level);
    load(a.weight.data() + i, weight);
    load(a.rim.data() + i, rim);
    load(counts.data() + i, count);
    load(a.step_x.data() + i, x);
    load(a.step_y.data() + i, y);
    load(a.blended.data() + i, blended);
    weight = count * rim > 0 ? weight : Lanes{};
    const Lanes below = w * b + blended;
    if constexpr (columns == kLayerColumns) {
      load(a.turn.value.data() + i, st);
      s += light.turn * st;
    }
    const Lanes shine = light.gain + light.slope_x * u + light.slope_y * v;
    const Lanes r = level - shine * s - light.ground * below;
    const Lanes q = light.ground * (wx * bx + wy * by), off = -light.ground * (b - mean);
    const Lanes shift_x = off * wx, shift_y = off * wy, on_x = weight * shift_x, on_y = weight * shift_y;
    qr += weight * q * r;
    qq += weight * q * q;
    xx += on_x * shift_x;
    xy += on_x * shift_y;
    yy += on_y * shift_y;
    xr += on_x * r;
    yr += on_y * r;
    const Lanes column[kLayerColumns] = {x, y, s, s * u, s * v, below, shine * st};
    for (int c = 0; c < columns; ++c) {
      mixed_x[c] += on_x * column[c];
      mixed_y[c] += on_y * column[c];
    }
  }
  LayerRimSums out{sum(qr), sum(qq), {sum(xx), sum(xy), sum(yy)}, {sum(xr), sum(yr)}, {}};
  for (std::size_t c = 0; c < kLayerColumns; ++c) out.mixed[c] = {sum(mixed_x[c]), sum(mixed_y[c])};
  return out;
}

#define TRIBOTRACK_VARIANT(suffix, ...)                                                                    \
  __VA_ARGS__ LayerNormal form_##suffix(LayerArrays& arrays, const std::vector<float>& mask,               \
                                        const LayerLight& light, const NoiseLaw& noise) {                  \
    return arrays.turn.value.empty() ? form_with<6>(arrays, mask, light, noise)                            \
                                     : form_with<7>(arrays, mask, light, noise);                           \
  }                                                                                                        \
  __VA_ARGS__ LayerForce force_##suffix(const LayerArrays& arrays, const LayerLight& light) {              \
    return arrays.turn.value.empty() ? force_with<false>(arrays, light) : force_with<true>(arrays, light); \
  }                                                                                                        \
  __VA_ARGS__ PlateauSums plateau_##suffix(const PlateauRow& row) {                                        \
    return plateau_of(row);                                                                                \
  }                                                                                                        \
  __VA_ARGS__ LayerRimSums rim_##suffix(const LayerArrays& arrays, const std::vector<float>& counts,       \
                                        const LayerLight& light, double ground_mean) {                     \
    return arrays.turn.value.empty() ? rim_with<6>(arrays, counts, light, ground_mean)                     \
                                     : rim_with<7>(arrays, counts, light, ground_mean);                    \
  }                                                                                                        \
  constexpr LayerKernels k_##suffix{#suffix, form_##suffix, force_##suffix, plateau_##suffix, rim_##suffix};

TRIBOTRACK_VARIANT(baseline)
TRIBOTRACK_VARIANT(avx2, TRIBOTRACK_AVX2)
#undef TRIBOTRACK_VARIANT

}  // namespace

std::vector<LayerKernels> all_layer_kernels() {
  return runnable(k_baseline, k_avx2);
}

const LayerKernels& layer_kernels() {
  static const LayerKernels fastest = all_layer_kernels().back();
  return fastest;
}

}  // namespace tribotrack::vision
