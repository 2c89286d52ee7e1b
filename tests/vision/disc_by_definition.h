// A sharp disc seen through Gaussian optics, and a texture, from the definition alone: slow and obviously
// right.
#pragma once

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>
#include <vector>

#include "vision/synthesis/texture.h"

namespace tribotrack::vision::test {

/// The share of the Gaussian about (rho, 0) that falls on the disc: Simpson's rule over the chords.
inline double share_on_disc(double rho, double radius, double blur) {
  const auto chord = [&](double x) {
    const double half = std::sqrt(std::max(0.0, radius * radius - x * x));
    const double z = (x - rho) / blur;
    return std::exp(-0.5 * z * z) / (std::sqrt(2 * std::numbers::pi) * blur) *
           std::erf(half / (std::sqrt(2.0) * blur));
  };
  // x = -R cos(a), so that the ends of the chords are smooth.
  const int steps = 200 + 2 * static_cast<int>(40 * radius / blur);
  double sum = 0;
  for (int k = 1; k < steps; ++k) {
    const double a = std::numbers::pi * k / steps;
    sum += (k % 2 == 1 ? 4 : 2) * chord(-radius * std::cos(a)) * radius * std::sin(a);
  }
  return sum * std::numbers::pi / steps / 3;
}

/// The same at many points: a fine table, read with straight lines (error below 1e-6).
class TabulatedDiscs {
 public:
  double share(double rho, double radius, double blur) {
    if (rho > radius + 6 * blur) return 0;
    if (rho < radius - 6 * blur) return 1;
    std::vector<double>& table = tables_[{radius, blur}];
    const double first = std::max(0.0, radius - 6.1 * blur);
    const double step = blur / 200;
    if (table.empty())
      for (double at = first; at < radius + 6.2 * blur; at += step)
        table.push_back(share_on_disc(first + static_cast<double>(table.size()) * step, radius, blur));
    const double place = (rho - first) / step;
    const auto cell = static_cast<std::size_t>(place);
    const double t = place - static_cast<double>(cell);
    return (1 - t) * table.at(cell) + t * table.at(cell + 1);
  }

 private:
  std::map<std::pair<double, double>, std::vector<double>> tables_;
};

/// Grey levels about zero at a place of the platform.
inline double texture_at(const PlatformTexture& texture, double x, double y) {
  double sum = 0;
  for (const auto& w : texture.waves()) sum += w.amplitude * std::cos(w.kx * x + w.ky * y + w.phase);
  return sum;
}

}  // namespace tribotrack::vision::test
