#include "vision/layers/learning/through_rim.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace tribotrack::vision {
namespace {
constexpr float kLeastShare = 0.1F;  ///< of the ground: less tells nothing
}

void look_through_rim(std::span<const KeptWindow> windows, const LayeredDisc& disc, double noise_variance,
                      GroundPicture& ground) {
  ground.forget_rim();
  // Whole places of the platform about the disc.
  const double inner = disc.rim().inner(), outer = disc.rim().outer();
  const int reach = static_cast<int>(std::ceil(outer)) + 1;
  Picture mask(2 * reach + 1, 2 * reach + 1);
  for (int y = -reach; y <= reach; ++y)
    for (int x = -reach; x <= reach; ++x) {
      const double rho = std::hypot(x, y);
      mask.at(x + reach, y + reach) = rho > inner - 1 && rho < outer + 1 ? 1.0F : 0.0F;
    }
  const std::vector<TilePlace> tiles = cover_with_tiles(mask);
  const std::size_t pixels = tiles.size() * kTilePixels;
  TileArrays level, shown, share, below;
  for (TileArrays* a : {&level, &shown, &share, &below}) {
    a->tiles = tiles.size();
    for (auto* v : {&a->value, &a->slope_x, &a->slope_y}) v->resize(pixels);
  }
  std::vector<float> known(pixels);
  std::vector<const float*> corners(tiles.size());
  const QuinticSpline share_spline(disc.share());
  QuinticSpline standing(disc.at(0));
  for (const KeptWindow& w : windows) {
    if (!w.explained) continue;
    const LayeredState& s = w.state;
    // The first place, and where the camera sees it.
    const int u0 = static_cast<int>(std::lround(s.centre.x - s.ground.x)) - reach;
    const int v0 = static_cast<int>(std::lround(s.centre.y - s.ground.y)) - reach;
    const double x = u0 + s.ground.x, y = v0 + s.ground.y;
    if (x < w.x || y < w.y || x + mask.width() > w.x + w.picture.width() ||
        y + mask.height() > w.y + w.picture.height())
      continue;
    if (disc.turning()) standing = QuinticSpline(disc.at(s.theta));
    const double left = x - s.centre.x + disc.half(), top = y - s.centre.y + disc.half();
    w.spline.sample_tiles(x - w.x, y - w.y, tiles, corners, false, level);
    standing.sample_tiles(left, top, tiles, corners, false, shown);
    share_spline.sample_tiles(left, top, tiles, corners, true, share);
    ground.sample_tiles(u0, v0, tiles, corners, below, known);
    for (std::size_t k = 0; k < pixels; ++k) {
      const int i = tiles[k / kTilePixels].x + static_cast<int>(k % kTile);
      const int j = tiles[k / kTilePixels].y + static_cast<int>(k % kTilePixels) / kTile;
      const double u = x + i - s.centre.x, v = y + j - s.centre.y;
      const double square = u * u + v * v;
      if (w.partly_unseen && !w.sees(x + i, y + j)) continue;
      if (share.value[k] < kLeastShare || square <= inner * inner || square >= outer * outer) continue;
      const double light = s.gain * (1 + s.slope_x * u + s.slope_y * v);
      const auto through = static_cast<float>(s.ground_gain) * share.value[k];
      const auto blended = static_cast<float>(s.ground_gain * disc.blend()) *
                           (share.slope_x[k] * below.slope_x[k] + share.slope_y[k] * below.slope_y[k]);
      ground.add_through_rim(
          u0 + i, v0 + j, through * (level.value[k] - static_cast<float>(light) * shown.value[k] - blended),
          through * through);
    }
  }
  ground.finish(noise_variance);
}

}  // namespace tribotrack::vision
