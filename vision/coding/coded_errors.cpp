#include "vision/coding/coded_errors.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace tribotrack::vision {
namespace {

/// Along one axis.
struct Axis {
  double still, moving, unnoticed;
};

/// Variances, px^2.
double added(const Axis& axis) {
  return (axis.still + kMovingShare * axis.moving) * axis.unnoticed * axis.unnoticed / 3;
}

void widen(TrackPoint& p, double add_x, double add_y) {
  const double covariance = p.rho_xy * p.sigma_x * p.sigma_y;
  p.sigma_x = std::sqrt(p.sigma_x * p.sigma_x + add_x);
  p.sigma_y = std::sqrt(p.sigma_y * p.sigma_y + add_y);
  p.rho_xy = covariance / (p.sigma_x * p.sigma_y);
}

}  // namespace

void widen_for_coding(const Coder& coder, const std::vector<WatchedFrame>& frames, std::int64_t first_index,
                      const Point& unnoticed, Track& track, CodedErrors& found) {
  for (const WatchedFrame& f : frames) {
    const auto place = static_cast<std::size_t>(f.index - first_index);
    if (place >= track.points.size() || track.points[place].status != TrackStatus::ok) continue;
    const double reach = coder.dead_zone * f.part.step;
    const Axis x{f.part.still.x, f.part.moving.x, reach * unnoticed.x};
    const Axis y{f.part.still.y, f.part.moving.y, reach * unnoticed.y};
    widen(track.points[place], added(x), added(y));
    const double n = static_cast<double>(++found.frames);
    const auto mean = [n](double& mean_so_far, double value) { mean_so_far += (value - mean_so_far) / n; };
    mean(found.step, f.part.step);
    mean(found.still, 0.5 * (x.still + y.still));
    mean(found.moving, 0.5 * (x.moving + y.moving));
    mean(found.unnoticed, 0.5 * (x.unnoticed + y.unnoticed));
  }
}

}  // namespace tribotrack::vision
