// Tags as OpenCV itself draws them, by its interface before 4.8 and by that of 4.8 and later.
#pragma once

#include <opencv2/aruco.hpp>

namespace tribotrack::vision {

/// One pixel a cell, with the tag's black border of one cell.
template <class Dictionary>
cv::Mat drawn_tag(const Dictionary& family, int id) {
  cv::Mat cells;
  const int side = family.markerSize + 2;
  if constexpr (requires { family.drawMarker(id, side, cells, 1); })
    family.drawMarker(id, side, cells, 1);
  else
    family.generateImageMarker(id, side, cells, 1);
  return cells;
}

}  // namespace tribotrack::vision
