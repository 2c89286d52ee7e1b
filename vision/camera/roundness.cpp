#include "vision/camera/roundness.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include "vision/discs/rim_steps.h"

namespace tribotrack::vision {
namespace {

constexpr double kInner = 0.6, kOuter = 1.5;  ///< of the radius: where the rim is looked for
constexpr double kHalfStep = 1.5;             ///< px: on both sides of an edge
constexpr int kRays = 72;

/// Place of the steepest edge that goes down outwards (sign 1) or up (-1), with how much it does.
std::pair<double, double> edge_along(const Picture& picture, const Circle& disc, const Point& to,
                                     double sign) {
  double place = 0, largest = 0;
  for (double r = kInner * disc.radius; r <= kOuter * disc.radius; r += 0.25) {
    const auto level = [&](double at) { return level_at(picture, disc.x + at * to.x, disc.y + at * to.y); };
    if (const double step = sign * (level(r - kHalfStep) - level(r + kHalfStep)); step > largest) {
      largest = step;
      place = r;
    }
  }
  return {place, largest};
}

}  // namespace

std::optional<std::string> roundness_warning(const Picture& picture, const Circle& disc) {
  constexpr double kOfRadius = 0.03, kLeast = 0.5, kOfScatter = 5;  // kLeast: px
  const double reach = kOuter * disc.radius + kHalfStep + 1;
  if (disc.radius < 4 * kHalfStep || disc.x < reach || disc.y < reach ||
      disc.x + reach > picture.width() - 1 || disc.y + reach > picture.height() - 1)
    return std::nullopt;
  std::vector<double> radius[2];
  double steps[2] = {0, 0};
  for (const int way : {0, 1})
    for (int k = 0; k < kRays; ++k) {
      const double theta = 2 * std::numbers::pi * k / kRays;
      const auto [place, step] =
          edge_along(picture, disc, {std::cos(theta), -std::sin(theta)}, way == 0 ? 1 : -1);
      radius[way].push_back(place);
      steps[way] += step;
    }
  const std::vector<double>& seen = radius[steps[1] > steps[0]];
  std::complex<double> harmonic[3];
  double square = 0;
  for (int k = 0; k < kRays; ++k) {
    for (int n = 0; n < 3; ++n)
      harmonic[n] +=
          seen[static_cast<std::size_t>(k)] / kRays * std::polar(1.0, 2 * std::numbers::pi * n * k / kRays);
    square += seen[static_cast<std::size_t>(k)] * seen[static_cast<std::size_t>(k)] / kRays;
  }
  const double mean = harmonic[0].real(), amplitude = 2 * std::abs(harmonic[2]);
  const double rest = std::sqrt(
      std::max(0.0, square - mean * mean - 2 * std::norm(harmonic[1]) - 2 * std::norm(harmonic[2])));
  if (!(amplitude > std::max(kLeast, kOfRadius * mean)) ||
      !(amplitude > kOfScatter * rest / std::sqrt(0.5 * kRays)))
    return std::nullopt;
  return fmt::format(
      "the disc is seen as an ellipse: its axes differ by {:.0f} %, the longer one at {:.0f} degrees; pixels "
      "that are "
      "not square, or a camera that looks from the side, put scale and alpha off by as much",
      200 * amplitude / mean, std::arg(harmonic[2]) / 2 * 180 / std::numbers::pi);
}

}  // namespace tribotrack::vision
