// Finding the corners of a calibration board in a picture.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "vision/calibration.h"
#include "vision/picture.h"

namespace tribotrack::vision {

/// Corners seen and where they lie on the board (mm, z = 0).
struct BoardView {
  std::vector<cv::Point2f> seen;
  std::vector<cv::Point3f> on_board;
};

/// Empty where no board is found.
BoardView find_board(const CalibrationBoard& board, const Picture& picture);

}  // namespace tribotrack::vision
