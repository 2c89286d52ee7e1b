// A camera calibrated with pictures of a flat board: lens, distortion, and the plane of the platform, from
// pixels to millimetres.
//
// OpenCV's calib3d (Zhang 2000) finds the camera by least squares over all corners of all pictures. Of the
// lens terms only those that pay are kept: the model with the least Bayesian information criterion n ln(RSS /
// n) + k ln n, n residuals, k unknowns.
//
// One picture shows the board lying on the platform and fixes the plane; the others show it tilted and fix
// the lens. The result is a map from pixels to mm on that plane, with its derivative for covariances:
//
//   CalibrationBoard board;
//   board.columns = 10, board.rows = 7, board.square_mm = 5;
//   const CalibrationPicture flat = calibration_picture("flat.png");
//   const CalibrationResult result = calibrate_camera(board, flat, calibration_pictures({"tilted/"}, flat));
//   std::cout << result.rms_px << " px rms, lens terms: " << result.model << "\n";
//   const PlanePoint p = result.calibration.locate({812.4, 377.9}, 3.2);  // 3.2 mm above the plane
//   const Eigen::Matrix2d covariance_mm = p.slope * covariance_px * p.slope.transpose();
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

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
  double distance_mm() const { return std::abs((plane.rotation.transpose() * plane.translation).z()); }
};

/// sqrt |det d(mm)/d(px)| in the middle of the picture.
double scale_in_the_middle(const CameraCalibration& calibration);

/// H with (X, Y, 1) ~ H (u, v, 1): from pixels freed of distortion, at the same camera matrix, to mm on the
/// plane.
Eigen::Matrix3d plane_homography(const CameraCalibration& calibration);

/// The pose turned within its plane so that x points right and y up in the middle of the picture, whichever
/// way the board lay.
PlanePose turned_to_picture(const CameraCalibration& calibration);

/// A flat checkerboard, found only when it is seen whole.
struct CalibrationBoard {
  int columns = 10, rows = 7;  ///< squares, not corners
  double square_mm = 0;
  double square_relative_sd = 0;  ///< how well the side of a square is known; enters the scale's sd
  /// Throws std::invalid_argument naming the member.
  void validate() const;
};

struct CalibrationPicture {
  std::string name;
  Picture picture;
};

/// How well one picture of the board fits.
struct PictureResult {
  std::string name;
  int corners = 0;
  double rms_px = 0;    ///< reprojection, per corner
  double tilt_rad = 0;  ///< between the board and the picture plane
};

struct CalibrationResult {
  CameraCalibration calibration;
  std::string model;               ///< the lens terms kept: "focal length", "k1", ...
  std::vector<std::string> tried;  ///< each model with its rms and its criterion
  double rms_px = 0;               ///< over all corners
  double focal_sd_px = 0;
  std::vector<PictureResult> pictures;  ///< the plane's first
  std::vector<std::string> left_out;    ///< pictures without a board, each with the reason
};

/// `plane` shows the board lying on the platform; `pictures` at least three others that show it tilted.
/// Throws InputError naming the picture and the remedy: no board in the plane's picture, too few others,
/// sizes that differ, all seen from one direction, a fit that means nothing.
CalibrationResult calibrate_camera(const CalibrationBoard& board, const CalibrationPicture& plane,
                                   const std::vector<CalibrationPicture>& pictures);

/// All pictures of these inputs, of a video or folder at most `most`, evenly spread; none that equals
/// `plane`. Throws InputError.
std::vector<CalibrationPicture> calibration_pictures(const std::vector<std::filesystem::path>& inputs,
                                                     const CalibrationPicture& plane, int most = 40);

/// A single picture (of a folder or a video the first).
CalibrationPicture calibration_picture(const std::filesystem::path& input);

}  // namespace tribotrack::vision
