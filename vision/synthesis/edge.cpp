#include "vision/synthesis/edge.h"

#include <algorithm>
#include <numbers>

#include "vision/synthesis/quadrature.h"

namespace tribotrack::vision {
namespace {

/// exp(-z) I_1(z), by its asymptotic series (Abramowitz and Stegun 9.7.1) where that is exact to 1e-15.
double scaled_bessel_i1(double z) {
  if (z < 40) return std::exp(-z) * std::cyl_bessel_i(1.0, z);
  double term = 1, sum = 1;
  for (int k = 1; k < 20; ++k) {
    term *= -(4.0 - (2 * k - 1) * (2 * k - 1)) / (k * 8 * z);
    sum += term;
    if (std::abs(term) < 1e-16) break;
  }
  return sum / std::sqrt(2 * std::numbers::pi * z);
}

/// Whole numbers in [low, high] and in the row; clamped first, because far-away circles do not fit an int.
PixelSpan pixels_between(double low, double high, int width) {
  PixelSpan span;
  span.first = static_cast<int>(std::ceil(std::clamp(low, 0.0, static_cast<double>(width))));
  span.last = static_cast<int>(std::floor(std::clamp(high, -1.0, width - 1.0)));
  return span;
}

/// Pixels of the row with any part within `radius` of the centre.
PixelSpan pixels_touched(Point centre, double radius, int row, int width) {
  const double dy = std::max(0.0, std::abs(row - centre.y) - 0.5);
  if (dy > radius) return {};
  const double half = std::sqrt(radius * radius - dy * dy) + 0.5;
  return pixels_between(centre.x - half, centre.x + half, width);
}

/// Pixels of the row that lie within `radius` of the centre with all their corners.
PixelSpan pixels_filled(Point centre, double radius, int row, int width) {
  const double dy = std::abs(row - centre.y) + 0.5;
  if (radius <= 0 || dy > radius) return {};
  const double half = std::sqrt(radius * radius - dy * dy) - 0.5;
  if (half < 0) return {};
  return pixels_between(centre.x - half, centre.x + half, width);
}

}  // namespace

BlurredCircle::BlurredCircle(double radius, double blur) : radius_(radius), blur_(blur) {
  if (!(radius > 0) || !(blur > 0)) return;
  constexpr int cells_per_blur = 24;
  first_ = std::max(0.0, radius - reach());
  const auto cells =
      static_cast<std::size_t>(std::ceil((radius + reach() - first_) / blur * cells_per_blur)) + 1;
  const double width = blur / cells_per_blur;
  cells_per_pixel_ = 1 / width;
  const double variance = blur * blur;
  const auto fall = [&](double rho) {
    const double apart = (radius - rho) / blur;
    return radius / variance * std::exp(-0.5 * apart * apart) * scaled_bessel_i1(rho * radius / variance);
  };
  const QuadratureRule rule = gauss_legendre(5);
  table_.resize(cells + 1);
  // From outside inwards; what lies beyond the table is its tail, less than reach() promises.
  double value = 0;
  for (std::size_t k = cells + 1; k-- > 0;) {
    const double rho = first_ + static_cast<double>(k) * width;
    if (k < cells)
      for (std::size_t i = 0; i < rule.nodes.size(); ++i)
        value += width * rule.weights[i] * fall(rho + (0.5 + rule.nodes[i]) * width);
    table_[k] = {value, -fall(rho) * width};
  }
}

RowBand row_band(const BlurredCircle& circle, std::span<const Point> centres, int row, int width) {
  RowBand band{{width, -1}, {0, width - 1}};
  for (const Point& centre : centres) {
    const PixelSpan touched = pixels_touched(centre, circle.radius() + circle.reach(), row, width);
    if (!touched.empty()) {
      band.touched.first = std::min(band.touched.first, touched.first);
      band.touched.last = std::max(band.touched.last, touched.last);
    }
    const PixelSpan filled = pixels_filled(centre, circle.radius() - circle.reach(), row, width);
    if (filled.empty()) {
      band.filled = {};
    } else {
      band.filled.first = std::max(band.filled.first, filled.first);
      band.filled.last = std::min(band.filled.last, filled.last);
    }
  }
  return band;
}

}  // namespace tribotrack::vision
