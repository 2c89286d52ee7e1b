// The step of the levels across a circle, direction by direction: is there a rim?
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "vision/picture.h"

namespace tribotrack::vision {

using Direction = std::pair<double, double>;  ///< cosine and sine
using Directions = std::vector<Direction>;

/// Linear between pixels; places beyond the picture are moved to its border.
inline double level_at(const Picture& picture, double x, double y) {
  x = std::clamp(x, 0.0, picture.width() - 1.001);
  y = std::clamp(y, 0.0, picture.height() - 1.001);
  const int ix = static_cast<int>(x);
  const int iy = static_cast<int>(y);
  const double fx = x - ix;
  const double fy = y - iy;
  return (1 - fy) * ((1 - fx) * picture.at(ix, iy) + fx * picture.at(ix + 1, iy)) +
         fy * ((1 - fx) * picture.at(ix, iy + 1) + fx * picture.at(ix + 1, iy + 1));
}

/// So many, evenly all round.
inline Directions directions(int count) {
  Directions out(static_cast<std::size_t>(count));
  for (int k = 0; k < count; ++k)
    out[static_cast<std::size_t>(k)] = {std::cos(2 * std::numbers::pi * k / count),
                                        std::sin(2 * std::numbers::pi * k / count)};
  return out;
}

/// As many as the rim has pixels, about.
inline Directions rim_directions(double radius) {
  return directions(std::clamp(static_cast<int>(4 * radius), 32, 256));
}

/// Step across the circle, inside minus outside, between places `half_width` px either side of it.
inline double rim_step(const Picture& picture, const Circle& c, double half_width, const Direction& u) {
  const double in = c.radius - half_width;
  const double out = c.radius + half_width;
  return level_at(picture, c.x + in * u.first, c.y + in * u.second) -
         level_at(picture, c.x + out * u.first, c.y + out * u.second);
}

/// The same all round.
inline std::vector<double> rim_steps(const Picture& picture, const Circle& c, double half_width,
                                     const Directions& around) {
  std::vector<double> steps;
  steps.reserve(around.size());
  for (const auto& u : around) steps.push_back(rim_step(picture, c, half_width, u));
  return steps;
}

/// Share of the steps that have the sign of the usual one and at least 0.4 of its size.
inline double coverage_of(const std::vector<double>& steps, double usual) {
  const auto seen = std::count_if(steps.begin(), steps.end(), [&](double s) { return s / usual > 0.4; });
  return static_cast<double>(seen) / static_cast<double>(steps.size());
}

/// Moves the circle uphill in the sum of steps across it, from up to `capture` px off; each step is capped so
/// that a few strong edges (a lamp, a neighbour) cannot outvote the rim. `polarity`: 1 for a bright disc, -1
/// for a dark one.
inline Circle climb_rim(const Picture& picture, Circle c, double capture, double polarity,
                        const Directions& around) {
  double cap = 1e9;
  const auto merit = [&](const Circle& t) {
    if (t.radius < 2) return -1e9;
    double sum = 0;
    for (const auto& u : around) sum += std::clamp(polarity * rim_step(picture, t, 1.25, u), -cap, cap);
    return sum;
  };
  {
    std::vector<double> sizes;
    for (double dr = -capture; dr <= capture; dr += 1)
      for (const double s : rim_steps(picture, {c.x, c.y, c.radius + dr}, 1.25, around))
        sizes.push_back(std::abs(s));
    std::sort(sizes.begin(), sizes.end());
    cap = std::max(1e-3, sizes[sizes.size() * 9 / 10]);
  }
  double best = merit(c);
  for (double step = std::max(0.5, capture / 2); step > 0.2;) {
    Circle better = c;
    for (int k = 0; k < 27; ++k) {
      const Circle t{c.x + (k % 3 - 1) * step, c.y + (k / 3 % 3 - 1) * step, c.radius + (k / 9 - 1) * step};
      const double m = merit(t);
      if (m > best) {
        best = m;
        better = t;
      }
    }
    if (better.x == c.x && better.y == c.y && better.radius == c.radius) step /= 2;
    c = better;
  }
  return c;
}

}  // namespace tribotrack::vision
