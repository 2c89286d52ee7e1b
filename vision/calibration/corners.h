// The corners of a checkerboard in a picture.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "vision/picture.h"

namespace tribotrack::vision {

/// The board's inner corners, row by row; empty where it is not seen whole. OpenCV's refinement brings them
/// to a tenth of a pixel or better, a fit of their edges to the noise's limit.
std::vector<cv::Point2f> board_corners(const Picture& levels, cv::Size inner);

}  // namespace tribotrack::vision
