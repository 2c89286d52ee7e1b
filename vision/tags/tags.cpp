#include "vision/tags/tags.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <stdexcept>
#include <unsupported/Eigen/NonLinearOptimization>
#include <unsupported/Eigen/NumericalDiff>

#include "vision/io/levels.h"
#include "vision/kernels/bspline.h"
#include "vision/kernels/plane.h"
#include "vision/tracker.h"

namespace tribotrack::vision {
namespace {

using cv::aruco::Dictionary;

/// As OpenCV before 4.7 and from 4.7 on hands a dictionary out.
[[maybe_unused]] cv::Ptr<Dictionary> shared(const cv::Ptr<Dictionary>& dictionary) {
  return dictionary;
}
[[maybe_unused]] cv::Ptr<Dictionary> shared(const Dictionary& dictionary) {
  return cv::makePtr<Dictionary>(dictionary);
}

}  // namespace

cv::Ptr<cv::aruco::Dictionary> tag_dictionary(const std::string& name) {
  static const std::array<const char*, 21> names = {
      "4x4_50",        "4x4_100",        "4x4_250",       "4x4_1000", "5x5_50",   "5x5_100",
      "5x5_250",       "5x5_1000",       "6x6_50",        "6x6_100",  "6x6_250",  "6x6_1000",
      "7x7_50",        "7x7_100",        "7x7_250",       "7x7_1000", "original", "apriltag_16h5",
      "apriltag_25h9", "apriltag_36h10", "apriltag_36h11"};
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end())
    throw std::invalid_argument(
        "dictionary must be one of 4x4_50, 4x4_100, ... 7x7_1000, original, apriltag_16h5, apriltag_25h9, "
        "apriltag_36h10, apriltag_36h11, not " +
        name);
  return shared(cv::aruco::getPredefinedDictionary(static_cast<int>(found - names.begin())));
}

void require_tag_family(const std::string& dictionary) {
  tag_dictionary(dictionary);
}

namespace {

/// 8 bits, the darkest and the brightest percent at the ends: detection wants them, accuracy does not suffer.
cv::Mat to_8_bit(const Picture& picture) {
  std::vector<float> sorted(picture.levels().begin(), picture.levels().end());
  const double low = level_of_share(sorted, 0.01),
               high = std::max(low + 1, double{level_of_share(sorted, 0.99)});
  cv::Mat out;
  matrix_of(picture).convertTo(out, CV_8U, 240 / (high - low), 8 - 240 * low / (high - low));
  return out;
}

constexpr double kOfCell = 0.45;    ///< a crossing reaches so far to both sides, in cells of the tag
constexpr double kFarthest = 6;     ///< px, and no farther
constexpr double kNearest = 1.5;    ///< px; smaller cells show no black and no white
constexpr double kStep = 0.25;      ///< px along a crossing
constexpr double kEnds = 0.12;      ///< of a side left out at both of its ends: the corner's own blur
constexpr int kRounds = 4;          ///< the crossings are laid about the line found before
constexpr std::size_t kFewest = 4;  ///< crossings of a side

/// p = foot + s along, for s of 0 to 1 from corner to corner; `out` points away from the tag.
struct Side {
  Eigen::Vector2d foot, along, out;
};

/// A straight line through the crossings, and the sd of its place in its middle, px.
struct Line {
  Eigen::Vector2d foot, direction;
  double sd = 0;
};

/// Where the edge lies on the crossing, from its middle outwards; nothing where black is not inside.
std::optional<double> edge_on(const QuinticSpline& spline, const Picture& picture,
                              const Eigen::Vector2d& middle, const Eigen::Vector2d& out, double reach) {
  const int steps = static_cast<int>(std::lround(2 * reach / kStep));
  const auto at = [&](int k) {
    const Eigen::Vector2d p = middle + (k * 2 * reach / steps - reach) * out;
    return spline.value(p.x(), p.y());
  };
  const Eigen::Vector2d inner = middle - reach * out, outer = middle + reach * out;
  for (const Eigen::Vector2d& p : {inner, outer})
    if (p.x() < 2 || p.y() < 2 || p.x() > picture.width() - 3 || p.y() > picture.height() - 3)
      return std::nullopt;
  const double black = at(0), white = at(steps);
  if (!(white > black)) return std::nullopt;
  double sum = 0.5 * (white - black);
  for (int k = 1; k < steps; ++k) sum += at(k) - black;
  return reach - 2 * reach / steps * sum / (white - black);
}

/// A line through the edge of one side.
std::optional<Line> line_of(const QuinticSpline& spline, const Picture& picture, const Side& side,
                            double reach) {
  const double length = side.along.norm();
  std::vector<std::pair<double, double>> crossings;  // along, outwards
  for (double s = kEnds; s <= 1 - kEnds; s += 1 / length)
    if (const auto edge = edge_on(spline, picture, side.foot + s * side.along, side.out, reach))
      crossings.emplace_back(s, *edge);
  if (crossings.size() < kFewest) return std::nullopt;
  const auto n = static_cast<double>(crossings.size());
  double s0 = 0, d0 = 0, ss = 0, sd = 0;
  for (const auto& [s, d] : crossings) s0 += s / n, d0 += d / n;
  for (const auto& [s, d] : crossings) ss += (s - s0) * (s - s0), sd += (s - s0) * (d - d0);
  const double slope = sd / ss;
  double residual = 0;
  for (const auto& [s, d] : crossings) residual += std::pow(d - d0 - slope * (s - s0), 2);
  return Line{side.foot + s0 * side.along + d0 * side.out, side.along + slope * side.out,
              std::sqrt(residual / (n - 2) / n)};
}

Eigen::Vector2d crossing_of(const Line& a, const Line& b) {
  Eigen::Matrix2d directions;
  directions << a.direction, -b.direction;
  const Eigen::Vector2d t = directions.inverse() * (b.foot - a.foot);
  return a.foot + t(0) * a.direction;
}

using Corners = std::array<Eigen::Vector2d, 4>;

double area_of(const Corners& c) {
  const Eigen::Vector2d p = c[2] - c[0], q = c[3] - c[1];
  return 0.5 * std::abs(p.x() * q.y() - p.y() * q.x());
}

/// rms of the corners' distance from the nearest square, by their four degrees of freedom.
double not_square(const Corners& c) {
  using Complex = std::complex<double>;
  Complex centre = 0, size = 0;
  std::array<Complex, 4> z;
  const double turn = (c[1] - c[0]).x() * (c[2] - c[1]).y() - (c[1] - c[0]).y() * (c[2] - c[1]).x();
  const Complex step = turn > 0 ? Complex(0, 1) : Complex(0, -1);
  std::array<Complex, 4> unit = {1, step, step * step, step * step * step};
  for (std::size_t k = 0; k < 4; ++k) z[k] = {c[k].x(), c[k].y()}, centre += z[k] / 4.0;
  for (std::size_t k = 0; k < 4; ++k) size += (z[k] - centre) * std::conj(unit[k]) / 4.0;
  double rest = 0;
  for (std::size_t k = 0; k < 4; ++k) rest += std::norm(z[k] - centre - size * unit[k]);
  return std::sqrt(rest / 4);
}

std::optional<Tag> measured(const QuinticSpline& spline, const Picture& picture,
                            const std::vector<cv::Point2f>& found, int cells) {
  Corners corners;
  for (std::size_t k = 0; k < 4; ++k) corners[k] = {found[k].x, found[k].y};
  double line_sd = 0;
  for (int round = 0; round < kRounds; ++round) {
    const Eigen::Vector2d centre = 0.25 * (corners[0] + corners[1] + corners[2] + corners[3]);
    const double reach = std::min(kOfCell * std::sqrt(area_of(corners)) / cells, kFarthest);
    if (!(reach >= kNearest)) return std::nullopt;
    std::array<Line, 4> lines;
    line_sd = 0;
    for (std::size_t k = 0; k < 4; ++k) {
      const Eigen::Vector2d a = corners[k], along = corners[(k + 1) % 4] - a;
      Eigen::Vector2d out(along.y(), -along.x());
      out.normalize();
      if (out.dot(a - centre) < 0) out = -out;
      const auto line = line_of(spline, picture, {a, along, out}, reach);
      if (!line) return std::nullopt;
      lines[k] = *line;
      line_sd += line->sd * line->sd / 4;
    }
    for (std::size_t k = 0; k < 4; ++k) corners[k] = crossing_of(lines[(k + 3) % 4], lines[k]);
  }
  Tag tag;
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();
  for (std::size_t k = 0; k < 4; ++k) {
    tag.corners[k] = {corners[k].x(), corners[k].y()};
    centre += corners[k] / 4;
  }
  tag.centre = {centre.x(), centre.y()};
  tag.side_px = std::sqrt(area_of(corners));
  // Of a square fitted to four corners of sd s: s / sqrt(2). A side between two lines of sd l: l sqrt(2).
  tag.side_sd_px = std::max(not_square(corners) / std::sqrt(2.0), std::sqrt(line_sd));
  return tag;
}

}  // namespace

std::vector<Tag> find_tags(const Picture& picture, const std::string& dictionary) {
  const auto family = tag_dictionary(dictionary);
  // AprilTag's search for quadrangles finds turned and noisy tags that OpenCV's own misses, of any family.
  const auto search = cv::makePtr<cv::aruco::DetectorParameters>();
  search->cornerRefinementMethod = cv::aruco::CORNER_REFINE_APRILTAG;
  std::vector<std::vector<cv::Point2f>> corners;
  std::vector<int> ids;
  cv::aruco::detectMarkers(to_8_bit(picture), family, corners, ids, search);
  std::vector<Tag> tags;
  if (ids.empty()) return tags;
  const QuinticSpline spline(picture);
  for (std::size_t k = 0; k < ids.size(); ++k)
    if (auto tag = measured(spline, picture, corners[k], family->markerSize + 2)) {
      tag->id = ids[k];
      tags.push_back(*tag);
    }
  std::ranges::sort(tags, [](const Tag& a, const Tag& b) { return a.side_px > b.side_px; });
  return tags;
}

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
