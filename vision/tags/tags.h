// Square tags (ArUco, AprilTag) in a picture, to a fraction of a pixel.
//
// OpenCV finds and reads them. Their corners are then where straight lines through the four sides of the
// black square meet: a side is crossed at many places, and an edge lies where the grey level, summed from one
// end of the crossing to the other, splits between that of black and that of white. A blur alike on both
// sides does not move it.
#pragma once

#include <array>
#include <opencv2/aruco.hpp>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "vision/picture.h"

namespace tribotrack::vision {

struct Tag {
  int id = -1;
  std::array<Point, 4> corners;  ///< of the black square, in the order of OpenCV
  Point centre;
  double side_px = 0;     ///< that of the square of the same area
  double side_sd_px = 0;  ///< from how well the corners are those of a square: a tilted tag's is larger
};

/// Largest first. Throws std::invalid_argument for a dictionary that is none.
std::vector<Tag> find_tags(const Picture& picture, const std::string& dictionary);

/// By its name, "4x4_50" .. "7x7_1000", "original", "apriltag_16h5", "apriltag_25h9", "apriltag_36h10" or
/// "apriltag_36h11". Throws std::invalid_argument naming them.
cv::Ptr<cv::aruco::Dictionary> tag_dictionary(const std::string& name);

/// The board's inner corners, row by row; empty where it is not seen whole. OpenCV's refinement brings them
/// to a tenth of a pixel or better, a fit of their edges to the noise's limit.
std::vector<cv::Point2f> board_corners(const Picture& levels, cv::Size inner);

}  // namespace tribotrack::vision
