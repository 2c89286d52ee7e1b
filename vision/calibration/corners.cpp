#include "vision/calibration/corners.h"

#include <algorithm>
#include <array>
#include <opencv2/aruco/charuco.hpp>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <utility>

#include "vision/calibration/corner_fit.h"
#include "vision/tags/dictionary.h"

namespace tribotrack::vision {
namespace {

constexpr std::size_t kFewestCorners = 8;
constexpr double kShareOfSquare = 0.35;  ///< of its side that a corner's window reaches

/// OpenCV's refinement (gradients all point to the corner: Foerstner and Guelch 1987) brings the corner to a
/// tenth of a pixel or better, the fit of its edges in the picture at its full depth to the noise's limit.
void refine(const Picture& picture, const cv::Mat& grey, std::vector<cv::Point2f>& corners, double reach) {
  const int half = std::clamp(static_cast<int>(reach), 2, 15);
  cv::cornerSubPix(grey, corners, {half, half}, {-1, -1},
                   {cv::TermCriteria::EPS | cv::TermCriteria::COUNT, 100, 1e-4});
  for (cv::Point2f& corner : corners)
    if (const auto fitted = fit_corner(picture, {corner.x, corner.y}, std::clamp(reach, 3.0, 15.0)))
      corner = {static_cast<float>(fitted->x), static_cast<float>(fitted->y)};
}

double nearest_neighbours_px(const std::vector<cv::Point2f>& corners) {
  double least = 1e9;
  for (std::size_t i = 1; i < corners.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) least = std::min(least, cv::norm(corners[i] - corners[j]));
  return least;
}

BoardView find_checkerboard(const CalibrationBoard& board, const Picture& levels, const cv::Mat& picture) {
  BoardView view;
  const cv::Size inner(board.columns - 1, board.rows - 1);
  const bool found = cv::findChessboardCorners(picture, inner, view.seen,
                                               cv::CALIB_CB_ADAPTIVE_THRESH | cv::CALIB_CB_NORMALIZE_IMAGE) ||
                     cv::findChessboardCornersSB(picture, inner, view.seen, cv::CALIB_CB_EXHAUSTIVE);
  if (!found) return {};
  refine(levels, picture, view.seen, kShareOfSquare * nearest_neighbours_px(view.seen));
  for (int y = 0; y < inner.height; ++y)
    for (int x = 0; x < inner.width; ++x)
      view.on_board.emplace_back(static_cast<float>(x * board.square_mm),
                                 static_cast<float>(y * board.square_mm), 0.0F);
  return view;
}

#if CV_VERSION_MAJOR * 100 + CV_VERSION_MINOR < 408
cv::Ptr<cv::aruco::CharucoBoard> charuco(const CalibrationBoard& board) {
  return cv::aruco::CharucoBoard::create(board.columns, board.rows, static_cast<float>(board.square_mm),
                                         static_cast<float>(board.marker_mm),
                                         tag_dictionary(board.dictionary));
}

const std::vector<cv::Point3f>& corners_of(const cv::aruco::CharucoBoard& board) {
  return board.chessboardCorners;
}
#else
/// The pattern that OpenCV drew before it had two: boards with an even number of rows differ.
cv::Ptr<cv::aruco::CharucoBoard> charuco(const CalibrationBoard& board) {
  auto pattern = cv::makePtr<cv::aruco::CharucoBoard>(
      cv::Size(board.columns, board.rows), static_cast<float>(board.square_mm),
      static_cast<float>(board.marker_mm), *tag_dictionary(board.dictionary));
  pattern->setLegacyPattern(true);
  return pattern;
}

std::vector<cv::Point3f> corners_of(const cv::aruco::CharucoBoard& board) {
  return board.getChessboardCorners();
}
#endif

BoardView find_charuco(const CalibrationBoard& board, const Picture& levels, const cv::Mat& picture) {
  const auto pattern = charuco(board);
  std::vector<std::vector<cv::Point2f>> markers;
  std::vector<int> marker_ids;
  cv::aruco::detectMarkers(picture, tag_dictionary(board.dictionary), markers, marker_ids);
  BoardView view;
  if (marker_ids.empty()) return {};
  std::vector<int> ids;
  cv::aruco::interpolateCornersCharuco(markers, marker_ids, picture, pattern, view.seen, ids);
  if (view.seen.size() < kFewestCorners) return {};
  // A corner's window must not reach the markers beside it.
  const double gap = 0.5 * (board.square_mm - board.marker_mm) / board.square_mm;
  refine(levels, picture, view.seen, nearest_neighbours_px(view.seen) * std::min(kShareOfSquare, gap));
  const auto& corners = corners_of(*pattern);
  for (const int id : ids) view.on_board.push_back(corners[static_cast<std::size_t>(id)]);
  return view;
}

}  // namespace

void CalibrationBoard::validate() const {
  if (columns < 3 || rows < 3) throw std::invalid_argument("the board must have at least 3 x 3 squares");
  if (!(square_mm > 0)) throw std::invalid_argument("square_mm must be greater than 0");
  if (!(square_relative_sd >= 0)) throw std::invalid_argument("the squares' sd must not be negative");
  if (kind == Kind::charuco) {
    if (!(marker_mm > 0 && marker_mm < square_mm))
      throw std::invalid_argument("marker_mm must be greater than 0 and less than square_mm");
    tag_dictionary(dictionary);
  }
}

BoardView find_board(const CalibrationBoard& board, const Picture& picture) {
  const cv::Mat grey = to_8_bit(picture);
  BoardView view = board.kind == CalibrationBoard::Kind::checkerboard
                       ? find_checkerboard(board, picture, grey)
                       : find_charuco(board, picture, grey);
  if (view.seen.size() < kFewestCorners && board.kind == CalibrationBoard::Kind::charuco) return {};
  return view;
}

}  // namespace tribotrack::vision
