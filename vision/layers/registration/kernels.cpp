#include "vision/layers/registration/kernels.h"

#include <cmath>

#include "vision/kernels/vector_kernels.h"

namespace tribotrack::vision {
namespace {

using Lanes = VectorOf<float, kTile>::type;  // a row of a tile

struct FloatLight {
  float gain, slope_x, slope_y, ground, blend, mean;
  explicit FloatLight(const LayerLight& l)
      : gain(static_cast<float>(l.gain)),
        slope_x(static_cast<float>(l.slope_x)),
        slope_y(static_cast<float>(l.slope_y)),
        ground(static_cast<float>(l.ground)),
        blend(static_cast<float>(l.blend)),
        mean(static_cast<float>(l.mean)) {}
};

}  // namespace

void LayerArrays::resize(std::size_t count) {
  tiles = count;
  for (TileArrays* pictures : {&part, &share, &ground}) pictures->resize(count);
  for (auto* array : {&u, &v, &level, &variance, &ground_variance, &weight, &step_x, &step_y, &below})
    array->resize(count * kTilePixels);
}

TRIBOTRACK_CLONES LayerNormal form_normal(LayerArrays& a, const std::vector<float>& mask,
                                          const LayerLight& at) {
  constexpr int kSums = std::tuple_size_v<LayerNormal>;
  const FloatLight light(at);
  Lanes total[kSums] = {};
  for (std::size_t i = 0; i < a.tiles * kTilePixels; i += kTile) {
    Lanes s, sx, sy, w, wx, wy, g, gx, gy, u, v, variance, unsure, counts;
    load(a.part.value.data() + i, s);
    load(a.part.slope_x.data() + i, sx);
    load(a.part.slope_y.data() + i, sy);
    load(a.share.value.data() + i, w);
    load(a.share.slope_x.data() + i, wx);
    load(a.share.slope_y.data() + i, wy);
    load(a.ground.value.data() + i, g);
    load(a.ground.slope_x.data() + i, gx);
    load(a.ground.slope_y.data() + i, gy);
    load(a.u.data() + i, u);
    load(a.v.data() + i, v);
    load(a.variance.data() + i, variance);
    load(a.ground_variance.data() + i, unsure);
    load(mask.data() + i, counts);
    const Lanes shine = light.gain + light.slope_x * u + light.slope_y * v;
    const Lanes own = s - light.mean * w;
    const Lanes under = light.ground * (g + light.mean), seen = light.ground * w;
    const Lanes weight = counts / (variance + seen * seen * unsure);
    Lanes column[kLayerColumns];
    const Lanes through = under - light.mean * shine;
    column[kStepX] = -(shine * sx + through * wx);
    column[kStepY] = -(shine * sy + through * wy);
    column[kGain] = own;
    column[kSlopeX] = u * own;
    column[kSlopeY] = v * own;
    column[kGround] = w * (g + light.mean) + light.blend * (wx * gx + wy * gy);
    store(weight, a.weight.data() + i);
    store(column[kStepX], a.step_x.data() + i);
    store(column[kStepY], a.step_y.data() + i);
    store(column[kGround], a.below.data() + i);
    for (int c = 0, k = 0; c < kLayerColumns; ++c) {
      const Lanes weighted = weight * column[c];
      for (int d = c; d < kLayerColumns; ++d, ++k) total[k] += weighted * column[d];
    }
  }
  LayerNormal out{};
  for (int k = 0; k < kSums; ++k) out[static_cast<std::size_t>(k)] = sum(total[k]);
  return out;
}

TRIBOTRACK_CLONES LayerForce layer_force(LayerArrays& a, const LayerLight& at, std::size_t tile,
                                         std::size_t end) {
  const FloatLight light(at);
  Lanes force[kLayerColumns] = {}, squares{}, largest{};
  Lanes n{}, sum_m{}, sum_i{}, sum_mm{}, sum_ii{}, sum_mi{};
  for (std::size_t i = tile * kTilePixels; i < end * kTilePixels; i += kTile) {
    Lanes s, w, wx, wy, g, gx, gy, u, v, level, weight, x, y;
    load(a.part.value.data() + i, s);
    load(a.share.value.data() + i, w);
    load(a.share.slope_x.data() + i, wx);
    load(a.share.slope_y.data() + i, wy);
    load(a.ground.value.data() + i, g);
    load(a.ground.slope_x.data() + i, gx);
    load(a.ground.slope_y.data() + i, gy);
    load(a.u.data() + i, u);
    load(a.v.data() + i, v);
    load(a.level.data() + i, level);
    load(a.weight.data() + i, weight);
    load(a.step_x.data() + i, x);
    load(a.step_y.data() + i, y);
    const Lanes shine = light.gain + light.slope_x * u + light.slope_y * v, own = s - light.mean * w;
    const Lanes below = w * (g + light.mean) + light.blend * (wx * gx + wy * gy);
    const Lanes model = shine * own + light.ground * below;
    store(below, a.below.data() + i);
    const Lanes r = level - model, wr = weight * r, square = wr * r;
    force[kStepX] += wr * x;
    force[kStepY] += wr * y;
    const Lanes on_part = wr * own;
    force[kGain] += on_part;
    force[kSlopeX] += on_part * u;
    force[kSlopeY] += on_part * v;
    force[kGround] += wr * below;
    squares += square;
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
  for (int i = 0; i < kTile; ++i) out.largest = std::fmax(out.largest, static_cast<double>(largest[i]));
  out.correlation = {sum(n), sum(sum_m), sum(sum_i), sum(sum_mm), sum(sum_ii), sum(sum_mi)};
  return out;
}

}  // namespace tribotrack::vision
