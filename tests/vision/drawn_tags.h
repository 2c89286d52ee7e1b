// Tags and boards as OpenCV itself draws them, by its interface before 4.8 and by that of 4.8 and later.
#pragma once

#include <opencv2/aruco.hpp>
#include <opencv2/aruco/charuco.hpp>

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

/// Of tags of the family 4x4_50, without a margin.
inline cv::Mat drawn_charuco(cv::Size squares, float square_mm, float marker_mm, int px_per_square) {
  cv::Mat drawn;
  const auto family = cv::aruco::getPredefinedDictionary(cv::aruco::DICT_4X4_50);
#if CV_VERSION_MAJOR * 100 + CV_VERSION_MINOR < 408
  cv::aruco::CharucoBoard::create(squares.width, squares.height, square_mm, marker_mm, family)
      ->draw(squares * px_per_square, drawn, 0, 1);
#else
  cv::aruco::CharucoBoard board(squares, square_mm, marker_mm, family);
  board.setLegacyPattern(true);
  board.generateImage(squares * px_per_square, drawn, 0, 1);
#endif
  return drawn;
}

}  // namespace tribotrack::vision
