// Calibrating a camera with pictures of a flat board: lens, distortion, and the plane of the platform.
//
// The camera is that of camera_calibration.h; OpenCV's calib3d (Zhang 2000) finds it by least squares over
// all corners of all pictures. Of the lens terms only those that pay are kept: the model with the least
// Bayesian information criterion n ln(RSS / n) + k ln n, n residuals, k unknowns.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "vision/camera_calibration.h"
#include "vision/picture.h"

namespace tribotrack::vision {

/// A flat board of squares. A checkerboard is found only when it is seen whole; a ChArUco board (a marker in
/// every white square) also in part.
struct CalibrationBoard {
  enum class Kind { checkerboard, charuco } kind = Kind::checkerboard;
  int columns = 10, rows = 7;  ///< squares, not corners
  double square_mm = 0;
  double square_relative_sd = 0;      ///< how well the side of a square is known; enters the scale's sd
  double marker_mm = 0;               ///< side of a ChArUco marker
  std::string dictionary = "4x4_50";  ///< of ArUco: 4x4_50 .. 7x7_1000, as OpenCV calls them
  /// Throws std::invalid_argument naming the member.
  void validate() const;
};

struct CalibrationPicture {
  std::string name;
  Picture picture;
};

/// What a picture of the board tells.
struct PictureResult {
  std::string name;
  int corners = 0;
  double rms_px = 0;  ///< reprojection, per corner
  double worst_px = 0;
  double tilt_rad = 0;  ///< between the board and the picture plane
};

struct CalibrationResult {
  CameraCalibration calibration;
  std::string model;                    ///< the lens terms kept: "focal length", "k1", ...
  std::vector<std::string> tried;       ///< each model with its rms and its criterion
  double rms_px = 0;                    ///< over all corners
  std::vector<PictureResult> pictures;  ///< the plane's first
  std::vector<std::string> left_out;    ///< pictures without a board, each with the reason
  /// Of the parameters named, in this order: fx, fy, cx, cy, lens terms kept, and the plane's rotation
  /// (Rodrigues) and translation.
  std::vector<std::string> covariance_of;
  Eigen::MatrixXd covariance;
};

/// `plane` shows the board lying on the platform; `pictures` at least three others that show it tilted.
/// Throws InputError naming the picture and the remedy: no board in the plane's picture, too few others,
/// sizes that differ, all seen from one direction, a fit that means nothing.
CalibrationResult calibrate_camera(const CalibrationBoard& board, const CalibrationPicture& plane,
                                   const std::vector<CalibrationPicture>& pictures);

}  // namespace tribotrack::vision
