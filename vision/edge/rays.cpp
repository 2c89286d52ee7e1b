#include "vision/edge/rays.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tribotrack::vision {
namespace {

/// Px: fields that end at the edge must be seen for a while; beyond some four blurs the ground, which moves
/// past, tells nothing of it.
constexpr int kInside = 7, kOutside = 4;
/// Of the radius: chamfers of discs reach a tenth, and the fields must be seen to end before them.
constexpr double kChamfer = 0.06;
constexpr int kLeastCore = 3;  ///< px about the centre that no ray enters
constexpr int kSplineReach = 4;

}  // namespace

RayGrid ray_grid(double radius) {
  RayGrid grid{.radius = radius, .inside = kInside, .outside = kOutside};
  grid.inside = std::max(grid.inside, static_cast<int>(std::lround(kInside + kChamfer * (radius - 30))));
  grid.inside = std::max(kLeastCore, std::min(grid.inside, static_cast<int>(radius) - kLeastCore));
  grid.azimuths = std::max(32, static_cast<int>(std::lround(2 * std::numbers::pi * radius / 16)) * 16);
  return grid;
}

RaySampler::RaySampler(const RayGrid& grid) : grid_(grid) {
  for (int p = 0; p < grid.azimuths; ++p) {
    const double phi = 2 * std::numbers::pi * p / grid.azimuths;
    for (std::size_t s = 0; s < grid.places(); ++s) {
      const double r = grid.radius + grid.offset(s);
      along_x_.push_back(static_cast<float>(r * std::cos(phi)));
      along_y_.push_back(static_cast<float>(r * std::sin(phi)));
    }
  }
  x_.resize(grid.size());
  y_.resize(grid.size());
}

Rect RaySampler::window(const Point& centre) const {
  const double reach = grid_.reach() + kSplineReach;
  const int x0 = static_cast<int>(std::floor(centre.x - reach)),
            y0 = static_cast<int>(std::floor(centre.y - reach));
  return {x0, y0, static_cast<int>(std::ceil(centre.x + reach)) - x0 + 1,
          static_cast<int>(std::ceil(centre.y + reach)) - y0 + 1};
}

void RaySampler::sample(const QuinticSpline& spline, const Rect& window, const Point& centre,
                        const RayLevels& out) {
  const auto x0 = static_cast<float>(centre.x - window.x), y0 = static_cast<float>(centre.y - window.y);
  for (std::size_t i = 0; i < x_.size(); ++i) {
    x_[i] = x0 + along_x_[i];
    y_[i] = y0 + along_y_[i];
  }
  spline.sample_places(x_, y_, out.level, out.slope_x, out.slope_y);
}

}  // namespace tribotrack::vision
