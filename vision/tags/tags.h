// Square tags (ArUco, AprilTag) in a picture, to a fraction of a pixel.
//
// OpenCV finds and reads them. Their corners are then where straight lines through the four sides of the
// black square meet: a side is crossed at many places, and an edge lies where the grey level, summed from one
// end of the crossing to the other, splits between that of black and that of white. A blur alike on both
// sides does not move it.
#pragma once

#include <array>
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

}  // namespace tribotrack::vision
