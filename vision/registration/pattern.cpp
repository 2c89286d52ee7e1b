#include "vision/registration/pattern.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "vision/io/levels.h"
#include "vision/kernels/median.h"
#include "vision/kernels/plane.h"

namespace tribotrack::vision {
namespace {

/// Of the disc's contrast: pixels outside the rim that differ by more from the mean rim profile belong to
/// something else (a neighbour touching the disc, its shadow) and are left out.
constexpr double kForeign = 0.35;

/// Profile at a fractional distance, linear between whole ones.
double profile_at(const std::vector<float>& profile, double rho) {
  const auto last = static_cast<double>(profile.size() - 1);
  rho = std::clamp(rho, 0.0, last);
  const auto k = std::min(static_cast<std::size_t>(rho), profile.size() - 2);
  const double t = rho - static_cast<double>(k);
  return (1 - t) * profile[k] + t * profile[k + 1];
}

/// Median grey level by distance from the centre, whole pixels 0 .. radius + 1.
std::vector<float> radial_profile(const Picture& picture, const Point& centre, double radius) {
  std::vector<std::vector<float>> rings(static_cast<std::size_t>(std::ceil(radius)) + 2);
  const int reach = static_cast<int>(std::ceil(radius)) + 1;
  const int cx = static_cast<int>(std::lround(centre.x));
  const int cy = static_cast<int>(std::lround(centre.y));
  for (int y = std::max(0, cy - reach); y <= std::min(picture.height() - 1, cy + reach); ++y)
    for (int x = std::max(0, cx - reach); x <= std::min(picture.width() - 1, cx + reach); ++x) {
      const auto ring = static_cast<std::size_t>(std::lround(std::hypot(x - centre.x, y - centre.y)));
      if (ring < rings.size()) rings[ring].push_back(picture.at(x, y));
    }
  std::vector<float> profile(rings.size());
  for (std::size_t k = 0; k < rings.size(); ++k)
    profile[k] = !rings[k].empty() ? median(rings[k]) : k > 0 ? profile[k - 1] : 0.0F;
  if (rings[0].empty()) profile[0] = profile[1];
  return profile;
}

}  // namespace

bool Pattern::inside(const Rect& bounds, const Point& at, double margin) const {
  const auto [half_x, half_y] = half();
  return at.x - half_x - margin >= bounds.x - 0.5 && at.y - half_y - margin >= bounds.y - 0.5 &&
         at.x + half_x + margin <= bounds.x + bounds.width - 0.5 &&
         at.y + half_y + margin <= bounds.y + bounds.height - 0.5;
}

bool Pattern::overlaps(const Rect& bounds, const Point& at) const {
  const auto [half_x, half_y] = half();
  return at.x + half_x > bounds.x - 0.5 && at.y + half_y > bounds.y - 0.5 &&
         at.x - half_x < bounds.x + bounds.width - 0.5 && at.y - half_y < bounds.y + bounds.height - 0.5;
}

Pattern disc_pattern(const Picture& first, const Circle& disc, double margin) {
  Pattern pattern;
  pattern.centre = {disc.x, disc.y};
  pattern.radius = disc.radius;
  const double mask = disc.radius + margin;
  pattern.window = window_about(pattern.centre, mask, bounds_of(first));
  pattern.weights = Picture(pattern.window.width, pattern.window.height);
  const std::vector<float> profile = radial_profile(first, pattern.centre, mask + 1);
  const double inner = profile_at(profile, std::max(0.0, disc.radius - 3));
  const double outer = profile_at(profile, disc.radius + 3);
  const double foreign = kForeign * std::abs(inner - outer);
  for (int y = 0; y < pattern.window.height; ++y)
    for (int x = 0; x < pattern.window.width; ++x) {
      const double rho = std::hypot(x + pattern.window.x - disc.x, y + pattern.window.y - disc.y);
      if (rho > mask) continue;
      const bool outside = rho > disc.radius + 0.5;
      const bool differs =
          std::abs(first.at(x + pattern.window.x, y + pattern.window.y) - profile_at(profile, rho)) > foreign;
      pattern.weights.at(x, y) = outside && differs ? 0.0F : 1.0F;
    }
  return pattern;
}

Pattern rectangle_pattern(const Rect& rectangle) {
  Pattern pattern;
  pattern.window = rectangle;
  pattern.weights = Picture(rectangle.width, rectangle.height, 1);
  pattern.centre = {rectangle.x + 0.5 * (rectangle.width - 1), rectangle.y + 0.5 * (rectangle.height - 1)};
  return pattern;
}

MaskedTemplate search_template(const Picture& first, const Pattern& pattern) {
  const Rect& window = pattern.window;
  MaskedTemplate out{Picture(window.width, window.height), Picture(window.width, window.height)};
  std::vector<float> profile;
  if (pattern.radius > 0) profile = radial_profile(first, pattern.centre, pattern.radius + 4);
  for (int y = 0; y < window.height; ++y)
    for (int x = 0; x < window.width; ++x) {
      const double rho = std::hypot(x + window.x - pattern.centre.x, y + window.y - pattern.centre.y);
      if (pattern.radius > 0) {
        out.levels.at(x, y) = static_cast<float>(profile_at(profile, rho));
        out.weights.at(x, y) = rho <= pattern.radius + 3 ? 1.0F : 0.0F;
      } else {
        out.levels.at(x, y) = first.at(x + window.x, y + window.y);
        out.weights.at(x, y) = 1;
      }
    }
  return out;
}

}  // namespace tribotrack::vision
