// Frames sampled along rays about the part's centre: place s of ray p lies at radius + s - inside px from the
// centre, in the direction 2 pi p / azimuths.
#pragma once

#include <cstdint>
#include <vector>

#include "vision/frame_source.h"
#include "vision/kernels/bspline.h"

namespace tribotrack::vision {

struct RayGrid {
  double radius = 0;            ///< px, about
  int inside = 7, outside = 4;  ///< px of it that are looked at
  int azimuths = 0;             ///< rays, about one a pixel of the rim
  std::size_t places() const { return static_cast<std::size_t>(inside + outside + 1); }
  std::size_t size() const { return places() * static_cast<std::size_t>(azimuths); }
  /// Of a place from the nominal rim, px.
  double offset(std::size_t place) const { return static_cast<double>(place) - inside; }
  double reach() const { return radius + outside; }
};

RayGrid ray_grid(double radius);

/// Levels ray by ray, RayGrid::size() of them; slopes, if wanted, in grey levels per px along x and y.
struct RayLevels {
  float* level = nullptr;
  float *slope_x = nullptr, *slope_y = nullptr;
};

class RaySampler {
 public:
  explicit RaySampler(const RayGrid& grid);
  /// The window that a sample about `centre` is taken from; not all of it need lie in the picture.
  Rect window(const Point& centre) const;
  /// From the spline of that window.
  void sample(const QuinticSpline& spline, const Rect& window, const Point& centre, const RayLevels& out);

 private:
  RayGrid grid_;
  std::vector<float> along_x_, along_y_, x_, y_;  ///< px from the centre, and in the window
};

}  // namespace tribotrack::vision
