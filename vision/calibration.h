// A calibrated camera: lens, distortion, and the plane of the platform, from pixels to millimetres.
//
// Whoever calibrates it - OpenCV's calibrateCamera with pictures of a board, of which one shows the board
// lying on the platform - hands over a lens and a pose. The result is a map from pixels to mm on that plane,
// with its derivative for covariances:
//
//   const PlanePoint p = calibration.locate({812.4, 377.9}, 3.2);  // 3.2 mm above the plane
//   const Eigen::Matrix2d covariance_mm = p.slope * covariance_px * p.slope.transpose();
#pragma once

#include <Eigen/Core>

#include "vision/picture.h"

namespace tribotrack::vision {

/// Pinhole with the radial and tangential distortion of Brown (1966): a point at (x, y) = (X/Z, Y/Z) is seen
/// at
///   u = fx x' + cx,  v = fy y' + cy,
///   x' = x (1 + k1 r^2 + k2 r^4 + k3 r^6) + 2 p1 x y + p2 (r^2 + 2 x^2),
///   y' = y (1 + k1 r^2 + k2 r^4 + k3 r^6) + p1 (r^2 + 2 y^2) + 2 p2 x y,   r^2 = x^2 + y^2.
struct LensModel {
  double fx = 1, fy = 1, cx = 0, cy = 0;  ///< px
  double k1 = 0, k2 = 0, p1 = 0, p2 = 0, k3 = 0;

  Point project(const Eigen::Vector2d& direction) const;
  /// (x, y) of a pixel, by Newton's method to 1e-13. Throws std::domain_error where the distortion folds the
  /// picture over (far outside what was calibrated).
  Eigen::Vector2d direction(Point pixel) const;
  /// d(u, v)/d(x, y).
  Eigen::Matrix2d slope(const Eigen::Vector2d& direction) const;
};

/// Where the platform's plane lies: camera = rotation * plane + translation, mm. The plane is z = 0, z up
/// towards the camera, x right and y up as seen by it in the middle of the picture.
struct PlanePose {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();
};

/// A place in mm, x right and y up, and its slope d(mm)/d(px) for the covariance.
struct PlanePoint {
  Eigen::Vector2d mm = Eigen::Vector2d::Zero();
  Eigen::Matrix2d slope = Eigen::Matrix2d::Zero();
};

struct CameraCalibration {
  int width = 0, height = 0;  ///< of the pictures it holds for, px
  LensModel lens;
  PlanePose plane;
  double mm_per_px = 0, mm_per_px_sd = 0;  ///< at the plane, in the middle of the picture

  /// What is seen at a pixel and lies height_mm above the plane.
  PlanePoint locate(Point pixel, double height_mm = 0) const;
  /// From the camera's pupil to the plane, mm.
  double distance_mm() const;
};

/// sqrt |det d(mm)/d(px)| in the middle of the picture.
double scale_in_the_middle(const CameraCalibration& calibration);

/// The pose turned within its plane so that x points right and y up in the middle of the picture, whichever
/// way the board lay.
PlanePose turned_to_picture(const CameraCalibration& calibration);

}  // namespace tribotrack::vision
