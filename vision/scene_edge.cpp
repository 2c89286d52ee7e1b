#include "vision/scene_edge.h"

#include <algorithm>

namespace tribotrack::vision {
namespace {

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

RowBand row_band(const BlurredCircle& circle, std::span<const Point> centres, int row, int width) {
  RowBand band{{width, -1}, {0, width - 1}};
  for (const Point& centre : centres) {
    const PixelSpan touched = pixels_touched(centre, circle.radius + circle.reach(), row, width);
    if (!touched.empty()) {
      band.touched.first = std::min(band.touched.first, touched.first);
      band.touched.last = std::max(band.touched.last, touched.last);
    }
    const PixelSpan filled = pixels_filled(centre, circle.radius - circle.reach(), row, width);
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
