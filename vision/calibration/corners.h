// Finding the corners of a calibration board in a picture.
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "vision/calibration.h"
#include "vision/picture.h"

namespace tribotrack::vision {

/// Corners seen and where they lie on the board (mm, z = 0).
struct BoardView {
  std::vector<cv::Point2f> seen;
  std::vector<cv::Point3f> on_board;
};

/// Empty where no board is found, or fewer than 8 corners of it.
BoardView find_board(const CalibrationBoard& board, const Picture& picture);

// The corner of four squares, to a few thousandths of a pixel.

/// Fits, by least squares over the pixels within `reach` px of `start`,
///   I(p) = m + g (p - q) + c erf(n1 (p - q) / (sqrt2 s)) erf(n2 (p - q) / (sqrt2 s)),
/// two edges of blur s crossing at q with normals n1, n2, on a shaded ground. The picture of a corner is the
/// same turned by half a turn, and so is the model: what it gets wrong of the edges does not move q. Nothing
/// where there is no such corner within 2 px.
std::optional<Point> fit_corner(const Picture& picture, Point start, double reach);

}  // namespace tribotrack::vision
