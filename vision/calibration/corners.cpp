#include "vision/calibration/corners.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <unsupported/Eigen/NonLinearOptimization>
#include <unsupported/Eigen/NumericalDiff>

#include "vision/tags/dictionary.h"

namespace tribotrack::vision {

namespace {

constexpr double kShareOfSquare = 0.35;  ///< of its side that a corner's window reaches

/// The picture of a corner within `reach` px of it: two edges of blur s that cross at q, with normals n1, n2,
/// on a shaded ground,
///   I(p) = m + g (p - q) + c erf(n1 (p - q) / (sqrt2 s)) erf(n2 (p - q) / (sqrt2 s)).
/// It is the same turned by half a turn: what it gets wrong of the edges does not move q.
struct CornerModel {
  using Scalar = double;
  using InputType = Eigen::VectorXd;
  using ValueType = Eigen::VectorXd;
  using JacobianType = Eigen::MatrixXd;
  static constexpr int InputsAtCompileTime = Eigen::Dynamic, ValuesAtCompileTime = Eigen::Dynamic;
  std::vector<Eigen::Vector3d> samples = {};  ///< x, y from the first guess of q, level

  int inputs() const { return 9; }
  int values() const { return static_cast<int>(samples.size()); }
  /// p: q, the angles of the two edges, ln s, m, c, g.
  int operator()(const InputType& p, ValueType& residuals) const {
    const double scale = std::exp(-p(4)) / std::numbers::sqrt2;
    for (std::size_t k = 0; k < samples.size(); ++k) {
      const double x = samples[k].x() - p(0), y = samples[k].y() - p(1);
      const double edges = std::erf((std::cos(p(2)) * y - std::sin(p(2)) * x) * scale) *
                           std::erf((std::cos(p(3)) * y - std::sin(p(3)) * x) * scale);
      residuals(static_cast<Eigen::Index>(k)) = p(5) + p(6) * edges + p(7) * x + p(8) * y - samples[k].z();
    }
    return 0;
  }
};

/// The corner near `start` by the fit of its edges, which run towards its neighbours; `start` where there is
/// no such corner within 2 px.
cv::Point2f refined(const Picture& picture, cv::Point2f start, cv::Point2f along_row,
                    cv::Point2f along_column, double reach) {
  CornerModel model;
  const int left = std::max(0, static_cast<int>(start.x - reach)),
            top = std::max(0, static_cast<int>(start.y - reach));
  double mean = 0, square = 0;
  for (int y = top; y <= std::min<double>(start.y + reach, picture.height() - 1); ++y)
    for (int x = left; x <= std::min<double>(start.x + reach, picture.width() - 1); ++x) {
      if (std::hypot(x - static_cast<double>(start.x), y - static_cast<double>(start.y)) > reach) continue;
      model.samples.emplace_back(x - static_cast<double>(start.x), y - static_cast<double>(start.y),
                                 picture.at(x, y));
      mean += picture.at(x, y);
      square += std::pow(picture.at(x, y), 2);
    }
  const auto count = static_cast<double>(model.samples.size());
  mean /= count;
  Eigen::VectorXd p(model.inputs()), up(model.values()), down(model.values());
  p << 0, 0, std::atan2(along_row.y, along_row.x), std::atan2(along_column.y, along_column.x), std::log(0.8),
      mean, std::sqrt(std::max(0.0, square / count - mean * mean)), 0, 0;
  Eigen::VectorXd mirrored = p;
  mirrored(6) = -p(6);
  model(p, up);
  model(mirrored, down);
  if (down.squaredNorm() < up.squaredNorm()) p = mirrored;
  Eigen::NumericalDiff<CornerModel> differentiated(model);
  Eigen::LevenbergMarquardt<Eigen::NumericalDiff<CornerModel>> search(differentiated);
  search.minimize(p);
  constexpr double kWander = 2;  // px
  if (!p.allFinite() || std::hypot(p(0), p(1)) > kWander) return start;
  return {start.x + static_cast<float>(p(0)), start.y + static_cast<float>(p(1))};
}

}  // namespace

std::vector<cv::Point2f> board_corners(const Picture& levels, cv::Size inner) {
  const cv::Mat picture = to_8_bit(levels);
  std::vector<cv::Point2f> corners;
  if (!cv::findChessboardCorners(picture, inner, corners,
                                 cv::CALIB_CB_ADAPTIVE_THRESH | cv::CALIB_CB_NORMALIZE_IMAGE) &&
      !cv::findChessboardCornersSB(picture, inner, corners, cv::CALIB_CB_EXHAUSTIVE))
    return {};
  const auto towards = [&](std::size_t k, bool back, std::size_t step) {
    return back ? corners[k] - corners[k - step] : corners[k + step] - corners[k];
  };
  const auto columns = static_cast<std::size_t>(inner.width);
  const auto along_row = [&](std::size_t k) { return towards(k, k % columns + 1 == columns, 1); };
  const auto along_column = [&](std::size_t k) { return towards(k, k + columns >= corners.size(), columns); };
  double side = 1e9;
  for (std::size_t k = 0; k < corners.size(); ++k)
    side = std::min({side, cv::norm(along_row(k)), cv::norm(along_column(k))});
  const double reach = std::clamp(kShareOfSquare * side, 3.0, 15.0);
  cv::cornerSubPix(picture, corners, {static_cast<int>(reach), static_cast<int>(reach)}, {-1, -1},
                   {cv::TermCriteria::EPS | cv::TermCriteria::COUNT, 100, 1e-4});
  std::vector<cv::Point2f> fitted;
  for (std::size_t k = 0; k < corners.size(); ++k)
    fitted.push_back(refined(levels, corners[k], along_row(k), along_column(k), reach));
  return fitted;
}

}  // namespace tribotrack::vision
