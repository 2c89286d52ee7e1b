// In the plane of a picture: distances, windows, OpenCV's view of a picture.
#pragma once

#include <algorithm>
#include <cmath>
#include <opencv2/core/mat.hpp>

#include "vision/picture.h"

namespace tribotrack::vision {

/// Between points, or the centres of circles.
double distance(const auto& a, const auto& b) {
  return std::hypot(a.x - b.x, a.y - b.y);
}

inline bool in_circle(const Circle& c, double x, double y) {
  return (x - c.x) * (x - c.x) + (y - c.y) * (y - c.y) <= c.radius * c.radius;
}

/// By so many pixels on every side, as far as `bounds` reach.
inline Rect grown(const Rect& r, int by, const Rect& bounds) {
  return common({r.x - by, r.y - by, r.width + 2 * by, r.height + 2 * by}, bounds);
}

/// The places of `region` that a window shows when they are moved by `displacement`, `border` px inside it at
/// least; width or height <= 0 where it shows none.
inline Rect places_shown(const Rect& region, const Rect& window, const Point& displacement, int border) {
  const int left = static_cast<int>(std::ceil(window.x + border - displacement.x));
  const int top = static_cast<int>(std::ceil(window.y + border - displacement.y));
  const double right = std::floor(window.x + window.width - 1 - border - displacement.x);
  const double bottom = std::floor(window.y + window.height - 1 - border - displacement.y);
  return common(region, {left, top, static_cast<int>(right) + 1 - left, static_cast<int>(bottom) + 1 - top});
}

/// Sums over frames at the places of a region.
struct PlaceSums {
  Picture sum, squares, count;
  explicit PlaceSums(const Rect& region) : sum(region.width, region.height), squares(sum), count(sum) {}
};

inline Rect bounds_of(const Picture& picture) {
  return {0, 0, picture.width(), picture.height()};
}

/// `to` has the window's size.
inline void copy_window(const Picture& from, const Rect& window, Picture& to) {
  for (int y = 0; y < window.height; ++y)
    std::copy_n(from.row(window.y + y).begin() + window.x, window.width, to.row(y).begin());
}

inline Picture part_of(const Picture& picture, const Rect& window) {
  Picture part(window.width, window.height);
  copy_window(picture, window, part);
  return part;
}

/// A header over the picture's own levels, which stay: to write through it changes them.
inline cv::Mat matrix_of(const Picture& picture) {
  return {picture.height(), picture.width(), CV_32F, const_cast<float*>(picture.levels().data())};
}

}  // namespace tribotrack::vision
