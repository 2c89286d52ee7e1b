#include "vision/layered_through_rim.h"

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
  const int reach = static_cast<int>(std::ceil(disc.rim().outer())) + 1;
  const int size = 2 * reach + 1;
  const auto pixels = static_cast<std::size_t>(size) * size;
  std::vector<float> level(pixels), shown(pixels), share(pixels), share_x(pixels), share_y(pixels),
      below(pixels), below_x(pixels), below_y(pixels), known(pixels);
  const QuinticSpline share_spline(disc.share());
  QuinticSpline standing(disc.at(0));
  const double inner = disc.rim().inner(), outer = disc.rim().outer();
  for (const KeptWindow& w : windows) {
    const LayeredState& s = w.state;
    // Whole places of the platform about the disc, and where the camera sees the first of them.
    const int u0 = static_cast<int>(std::lround(s.centre.x - s.ground.x)) - reach;
    const int v0 = static_cast<int>(std::lround(s.centre.y - s.ground.y)) - reach;
    const double x = u0 + s.ground.x, y = v0 + s.ground.y;
    if (x < w.x || y < w.y || x + size > w.x + w.picture.width() || y + size > w.y + w.picture.height())
      continue;
    if (disc.turning()) standing = QuinticSpline(disc.at(s.theta));
    const double left = x - s.centre.x + disc.half(), top = y - s.centre.y + disc.half();
    w.spline.sample_window(x - w.x, y - w.y, size, size, level.data(), nullptr, nullptr);
    standing.sample_window(left, top, size, size, shown.data(), nullptr, nullptr);
    share_spline.sample_window(left, top, size, size, share.data(), share_x.data(), share_y.data());
    ground.sample(u0, v0, size, size, below.data(), known.data(), below_x.data(), below_y.data());
    for (int j = 0; j < size; ++j)
      for (int i = 0; i < size; ++i) {
        const auto k = static_cast<std::size_t>(j) * size + i;
        if (share[k] < kLeastShare) continue;
        const double u = x + i - s.centre.x, v = y + j - s.centre.y;
        const double square = u * u + v * v;
        if (square <= inner * inner || square >= outer * outer) continue;
        const double light = s.gain * (1 + s.slope_x * u + s.slope_y * v);
        const auto through = static_cast<float>(s.ground_gain) * share[k];
        const auto blended = static_cast<float>(s.ground_gain * disc.blend()) *
                             (share_x[k] * below_x[k] + share_y[k] * below_y[k]);
        ground.add_through_rim(u0 + i, v0 + j,
                               through * (level[k] - static_cast<float>(light) * shown[k] - blended),
                               through * through);
      }
  }
  ground.finish(noise_variance);
}

}  // namespace tribotrack::vision
