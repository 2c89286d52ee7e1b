#include "vision/track.h"

#include <Eigen/Core>
#include <cmath>

namespace tribotrack::vision {

const char* to_string(TrackStatus status) {
  switch (status) {
    case TrackStatus::ok:
      return "ok";
    case TrackStatus::edge:
      return "edge";
    case TrackStatus::lost:
      break;
  }
  return "lost";
}

std::vector<std::optional<MillimetrePoint>> Track::to_millimetres(const Scale& scale,
                                                                  double xi_axis_rad) const {
  std::vector<std::optional<MillimetrePoint>> out(points.size());
  // From pixels (x right, y down) to millimetres (y up, turned by -xi).
  const double c = std::cos(xi_axis_rad);
  const double s = std::sin(xi_axis_rad);
  Eigen::Matrix2d to_mm;
  to_mm << c, -s, -s, -c;
  to_mm *= scale.mm_per_px;
  const TrackPoint* origin = nullptr;
  for (std::size_t k = 0; k < points.size(); ++k) {
    const TrackPoint& p = points[k];
    if (p.status != TrackStatus::ok || (has_marker && !p.marker)) continue;
    if (!origin) origin = &p;
    Eigen::Vector2d moved(p.x - origin->x, p.y - origin->y);
    const double covariance = p.rho_xy * p.sigma_x * p.sigma_y;
    Eigen::Matrix2d spread;
    spread << p.sigma_x * p.sigma_x, covariance, covariance, p.sigma_y * p.sigma_y;
    if (has_marker) {
      moved -= Eigen::Vector2d(p.marker->x - origin->marker->x, p.marker->y - origin->marker->y);
      spread.diagonal().array() += p.marker->sigma * p.marker->sigma;
    }
    const Eigen::Vector2d place = to_mm * moved;
    const Eigen::Matrix2d spread_mm = to_mm * spread * to_mm.transpose();
    MillimetrePoint m;
    m.x_mm = place.x();
    m.y_mm = place.y();
    m.sigma_x_mm = std::sqrt(spread_mm(0, 0));
    m.sigma_y_mm = std::sqrt(spread_mm(1, 1));
    const double product = m.sigma_x_mm * m.sigma_y_mm;
    m.rho_xy = product > 0 ? spread_mm(0, 1) / product : 0;
    out[k] = m;
  }
  return out;
}

}  // namespace tribotrack::vision
