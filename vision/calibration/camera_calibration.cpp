// A calibrated camera's geometry: from pixels to millimetres on the platform's plane.
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <stdexcept>

#include "vision/calibration.h"

namespace tribotrack::vision {

Point LensModel::project(const Eigen::Vector2d& d) const {
  const double x = d.x(), y = d.y();
  const double r2 = x * x + y * y;
  const double radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3));
  return {fx * (x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)) + cx,
          fy * (y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y) + cy};
}

Eigen::Matrix2d LensModel::slope(const Eigen::Vector2d& d) const {
  const double x = d.x(), y = d.y();
  const double r2 = x * x + y * y;
  const double radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3));
  const double rise = 2 * (k1 + r2 * (2 * k2 + r2 * 3 * k3));  // d radial / dx = rise x
  Eigen::Matrix2d s;
  s << radial + rise * x * x + 2 * p1 * y + 6 * p2 * x, rise * x * y + 2 * p1 * x + 2 * p2 * y,
      rise * x * y + 2 * p1 * x + 2 * p2 * y, radial + rise * y * y + 6 * p1 * y + 2 * p2 * x;
  s.row(0) *= fx;
  s.row(1) *= fy;
  return s;
}

Eigen::Vector2d LensModel::direction(Point pixel) const {
  Eigen::Vector2d d((pixel.x - cx) / fx, (pixel.y - cy) / fy);
  for (int k = 0; k < 50; ++k) {
    const Point seen = project(d);
    const Eigen::Matrix2d s = slope(d);
    if (!(s.determinant() > 0)) break;
    const Eigen::Vector2d step = s.inverse() * Eigen::Vector2d(pixel.x - seen.x, pixel.y - seen.y);
    d += step;
    if (step.norm() < 1e-13) return d;
  }
  throw std::domain_error("a pixel lies outside what the camera's calibration covers");
}

PlanePoint CameraCalibration::locate(Point pixel, double height_mm) const {
  const Eigen::Vector2d d = lens.direction(pixel);
  // The ray in the plane's axes: pupil + t ray.
  const Eigen::Matrix3d back = plane.rotation.transpose();
  const Eigen::Vector3d pupil = -back * plane.translation;
  const Eigen::Vector3d ray = back * Eigen::Vector3d(d.x(), d.y(), 1);
  const double t = (height_mm - pupil.z()) / ray.z();
  PlanePoint out;
  out.mm = (pupil + t * ray).head<2>();
  // d(mm)/d(x, y): along the ray's change, and back to the plane along the ray.
  Eigen::Matrix2d by_direction;
  for (int i = 0; i < 2; ++i) {
    const Eigen::Vector3d change = back.col(i);
    by_direction.col(i) = t * (change - ray * (change.z() / ray.z())).head<2>();
  }
  out.slope = by_direction * lens.slope(d).inverse();
  return out;
}

double CameraCalibration::distance_mm() const {
  return std::abs((plane.rotation.transpose() * plane.translation).z());
}

double scale_in_the_middle(const CameraCalibration& c) {
  return std::sqrt(std::abs(c.locate({0.5 * (c.width - 1), 0.5 * (c.height - 1)}).slope.determinant()));
}

PlanePose turned_to_picture(const CameraCalibration& calibration) {
  CameraCalibration c = calibration;
  // A board's z points away from the camera or towards it; ours towards it.
  if ((c.plane.rotation.transpose() * c.plane.translation).z() > 0) {
    const Eigen::Matrix3d over = Eigen::Vector3d(1, -1, -1).asDiagonal();
    c.plane.rotation = c.plane.rotation * over;
  }
  const Eigen::Matrix2d slope = c.locate({0.5 * (c.width - 1), 0.5 * (c.height - 1)}).slope;
  const double angle = std::atan2(slope(1, 0), slope(0, 0));
  c.plane.rotation = c.plane.rotation * Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  return c.plane;
}

}  // namespace tribotrack::vision
