#include "vision/calibration/corners.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <stdexcept>
#include <vector>

#include "vision/tags/dictionary.h"

namespace tribotrack::vision {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr int kRing = 72;             ///< places looked at around the corner
constexpr double kWander = 2;         ///< px from the start
constexpr double kLeastContrast = 2;  ///< grey levels

/// q, the angles of the two edges, log s, m, c, g.
using Parameters = Eigen::Matrix<double, 9, 1>;

struct Sample {
  double x, y, level;
};

double model(const Parameters& p, double x, double y) {
  const double dx = x - p(0), dy = y - p(1);
  const double scale = 1 / (std::numbers::sqrt2 * std::exp(p(4)));
  const double across1 = (std::cos(p(2)) * dy - std::sin(p(2)) * dx) * scale;
  const double across2 = (std::cos(p(3)) * dy - std::sin(p(3)) * dx) * scale;
  return p(5) + p(7) * dx + p(8) * dy + p(6) * std::erf(across1) * std::erf(across2);
}

double level_at(const Picture& picture, double x, double y) {
  const int ix = std::clamp(static_cast<int>(std::floor(x)), 0, picture.width() - 2);
  const int iy = std::clamp(static_cast<int>(std::floor(y)), 0, picture.height() - 2);
  const double fx = x - ix, fy = y - iy;
  return (1 - fy) * ((1 - fx) * picture.at(ix, iy) + fx * picture.at(ix + 1, iy)) +
         fy * ((1 - fx) * picture.at(ix, iy + 1) + fx * picture.at(ix + 1, iy + 1));
}

/// Where a ring about the corner changes between dark and bright: four times, opposite ones on one edge.
std::optional<Parameters> first_guess(const Picture& picture, Point at, double radius) {
  std::vector<double> ring;
  for (int k = 0; k < kRing; ++k) {
    const double a = 2 * kPi * k / kRing;
    ring.push_back(level_at(picture, at.x + radius * std::cos(a), at.y + radius * std::sin(a)));
  }
  const auto [least, most] = std::minmax_element(ring.begin(), ring.end());
  const double middle = 0.5 * (*least + *most);
  const double contrast = 0.5 * (*most - *least);
  if (contrast < kLeastContrast) return std::nullopt;
  std::vector<double> crossings;
  for (int k = 0; k < kRing; ++k) {
    const double here = ring[static_cast<std::size_t>(k)] - middle;
    const double next = ring[static_cast<std::size_t>((k + 1) % kRing)] - middle;
    if ((here < 0) != (next < 0)) crossings.push_back(2 * kPi * (k + here / (here - next)) / kRing);
  }
  if (crossings.size() != 4) return std::nullopt;
  Parameters p;
  p << at.x, at.y, 0.5 * (crossings[0] + crossings[2] - kPi), 0.5 * (crossings[1] + crossings[3] - kPi),
      std::log(0.8), middle, contrast, 0, 0;
  // The sign of c: what lies midway between the first two crossings.
  const double a = 0.5 * (crossings[0] + crossings[1]);
  const double x = at.x + radius * std::cos(a), y = at.y + radius * std::sin(a);
  if ((level_at(picture, x, y) - middle) * (model(p, x, y) - middle) < 0) p(6) = -contrast;
  return p;
}

/// Fits, by least squares over the pixels within `reach` px of `start`,
///   I(p) = m + g (p - q) + c erf(n1 (p - q) / (sqrt2 s)) erf(n2 (p - q) / (sqrt2 s)),
/// two edges of blur s crossing at q with normals n1, n2, on a shaded ground. The picture of a corner is the
/// same turned by half a turn, and so is the model: what it gets wrong of the edges does not move q. Nothing
/// where there is no such corner within 2 px.
std::optional<Point> fit_corner(const Picture& picture, Point start, double reach) {
  if (start.x < reach || start.y < reach || start.x > picture.width() - 1 - reach ||
      start.y > picture.height() - 1 - reach)
    return std::nullopt;
  const auto guess = first_guess(picture, start, 0.7 * reach);
  if (!guess) return std::nullopt;
  std::vector<Sample> samples;
  for (int y = static_cast<int>(std::ceil(start.y - reach)); y <= start.y + reach; ++y)
    for (int x = static_cast<int>(std::ceil(start.x - reach)); x <= start.x + reach; ++x)
      if (std::hypot(x - start.x, y - start.y) <= reach)
        samples.push_back({static_cast<double>(x), static_cast<double>(y), picture.at(x, y)});
  Parameters p = *guess;
  const auto cost_of = [&](const Parameters& at) {
    double cost = 0;
    for (const Sample& s : samples) cost += std::pow(s.level - model(at, s.x, s.y), 2);
    return cost;
  };
  double cost = cost_of(p);
  double damping = 1e-3;
  for (int round = 0; round < 40; ++round) {
    Eigen::Matrix<double, 9, 9> normal = Eigen::Matrix<double, 9, 9>::Zero();
    Parameters gradient = Parameters::Zero();
    for (const Sample& s : samples) {
      const double here = model(p, s.x, s.y);
      Parameters slope;
      for (int i = 0; i < 9; ++i) {
        Parameters moved = p;
        moved(i) += 1e-5;
        slope(i) = (model(moved, s.x, s.y) - here) * 1e5;
      }
      normal += slope * slope.transpose();
      gradient += slope * (s.level - here);
    }
    double moved = 0;
    bool improved = false;
    for (int tries = 0; tries < 8 && !improved; ++tries) {
      Eigen::Matrix<double, 9, 9> damped = normal;
      damped.diagonal() *= 1 + damping;
      const Parameters step = damped.ldlt().solve(gradient);
      Parameters trial = p + step;
      trial(4) = std::clamp(trial(4), std::log(0.2), std::log(0.5 * reach));
      const double trial_cost = cost_of(trial);
      if (trial_cost <= cost) {
        moved = std::hypot(step(0), step(1));
        p = trial;
        cost = trial_cost;
        damping = std::max(1e-9, damping / 10);
        improved = true;
      } else {
        damping *= 10;
      }
    }
    if (!improved || moved < 1e-5) break;
  }
  if (!p.allFinite() || std::hypot(p(0) - start.x, p(1) - start.y) > kWander) return std::nullopt;
  return Point{p(0), p(1)};
}

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

}  // namespace

void CalibrationBoard::validate() const {
  if (columns < 3 || rows < 3) throw std::invalid_argument("the board must have at least 3 x 3 squares");
  if (!(square_mm > 0)) throw std::invalid_argument("square_mm must be greater than 0");
  if (!(square_relative_sd >= 0)) throw std::invalid_argument("the squares' sd must not be negative");
}

BoardView find_board(const CalibrationBoard& board, const Picture& levels) {
  const cv::Mat picture = to_8_bit(levels);
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

}  // namespace tribotrack::vision
