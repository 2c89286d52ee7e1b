#include "vision/layers/model/light.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <utility>

namespace tribotrack::vision {
namespace {

constexpr double kUnknownScatter = 0.1;  ///< of the noise's variance: a scatter below goes unnoticed
constexpr double kNoChance = 5;          ///< of Fisher's ratio: once in 4000 fields of forty slopes
constexpr double kNoSpread = 0.5;        ///< px: places that differ by less tell nothing of S

}  // namespace

Eigen::Vector3d IlluminationSlope::terms(const Point& place) const {
  return {1, place.x - middle_.x, place.y - middle_.y};
}

IlluminationSlope::IlluminationSlope(std::span<const MeasuredSlope> slopes) {
  const auto n = static_cast<double>(slopes.size());
  if (slopes.size() < 4) throw std::invalid_argument("IlluminationSlope: fewer than four slopes");
  for (const MeasuredSlope& s : slopes) {
    middle_.x += s.place.x / n;
    middle_.y += s.place.y / n;
    noise_ += s.variance / n;
  }
  Eigen::Matrix3d normal = n * Eigen::Vector3d(0, kNoSpread * kNoSpread, kNoSpread * kNoSpread).asDiagonal();
  Eigen::Matrix<double, 3, 2> right = Eigen::Matrix<double, 3, 2>::Zero();
  for (const MeasuredSlope& s : slopes) {
    const Eigen::Vector3d t = terms(s.place);
    normal += t * t.transpose();
    right += t * Eigen::RowVector2d(s.slope_x, s.slope_y);
  }
  inverse_ = normal.inverse();
  field_ = inverse_ * right;
  double square = 0, even = 0;
  for (const MeasuredSlope& s : slopes) even += s.slope_x * s.slope_x + s.slope_y * s.slope_y;
  for (const MeasuredSlope& s : slopes)
    square += (Eigen::Vector2d(s.slope_x, s.slope_y) - field_.transpose() * terms(s.place)).squaredNorm();
  // Fisher's ratio: what each of the field's six numbers explains over what is left of each degree of
  // freedom.
  known_ = (even - square) / 6 > kNoChance * square / (2 * (n - 3));
  scatter_ = std::max(0.0, square / (2 * (n - 3)) - noise_) + kUnknownScatter * noise_;
}

LightPrior IlluminationSlope::at(const Point& place) const {
  if (!known_) return {};
  const Eigen::Vector3d t = terms(place);
  const Eigen::Vector2d g = field_.transpose() * t;
  return {g.x(), g.y(), std::sqrt(scatter_ + noise_ * t.dot(inverse_ * t))};
}

namespace {

constexpr double kSmooth = 4;        ///< px: the least width of a light that is learnt at once
constexpr double kLeastSeen = 0.01;  ///< frames in the surroundings: beyond, there is no light
constexpr double kHeld = 0.1;        ///< frames: what a level of 0 counts as
constexpr double kFewest = 3;        ///< frames that tell what changes at a pixel

/// A Gaussian; beyond the border nothing was seen.
Picture blurred(Picture picture) {
  const cv::Mat levels(picture.height(), picture.width(), CV_32F, picture.levels().data());
  cv::GaussianBlur(levels, levels, {}, kSmooth, kSmooth, cv::BORDER_CONSTANT);
  return picture;
}

/// sum / count, each place by the plane that fits its surroundings: continued by a few pixels beyond what was
/// seen.
Picture smooth_plane(const Picture& sum, const Picture& count) {
  const int width = sum.width(), height = sum.height();
  const auto moment = [&](const Picture& of, int p, int q) {
    Picture out(width, height);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x)
        out.at(x, y) =
            static_cast<float>(std::pow(x - 0.5 * width, p) * std::pow(y - 0.5 * height, q)) * of.at(x, y);
    return blurred(std::move(out));
  };
  const std::array<Picture, 6> weights{moment(count, 0, 0), moment(count, 1, 0), moment(count, 0, 1),
                                       moment(count, 2, 0), moment(count, 1, 1), moment(count, 0, 2)};
  const std::array<Picture, 3> levels{moment(sum, 0, 0), moment(sum, 1, 0), moment(sum, 0, 1)};
  Picture out(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const auto w = [&](std::size_t k) { return static_cast<double>(weights[k].at(x, y)); };
      const auto l = [&](std::size_t k) { return static_cast<double>(levels[k].at(x, y)); };
      const double n = w(0), cx = x - 0.5 * width, cy = y - 0.5 * height;
      if (!(n > kLeastSeen)) continue;
      // About the place itself.
      const double mx = w(1) - cx * n, my = w(2) - cy * n;
      Eigen::Matrix3d normal;
      normal << n, mx, my, mx, w(3) - 2 * cx * w(1) + cx * cx * n, w(4) - cx * w(2) - cy * w(1) + cx * cy * n,
          my, w(4) - cx * w(2) - cy * w(1) + cx * cy * n, w(5) - 2 * cy * w(2) + cy * cy * n;
      // A slope must be seen over some pixels.
      normal.diagonal().tail<2>().array() += kHeld * kSmooth * kSmooth;
      normal(0, 0) += kHeld;
      const Eigen::Vector3d right(l(0), l(1) - cx * l(0), l(2) - cy * l(0));
      out.at(x, y) = static_cast<float>(normal.ldlt().solve(right).x());
    }
  return out;
}

/// Pixels of the camera about a centre, as far as they lie in a window of this size.
Rect about(const Point& centre, double reach, int x, int y, const Picture& window) {
  const int x0 = std::max(x, static_cast<int>(std::ceil(centre.x - reach))),
            y0 = std::max(y, static_cast<int>(std::ceil(centre.y - reach)));
  const int x1 = std::min(x + window.width() - 1, static_cast<int>(std::floor(centre.x + reach))),
            y1 = std::min(y + window.height() - 1, static_cast<int>(std::floor(centre.y + reach)));
  return {x0, y0, std::max(0, x1 - x0 + 1), std::max(0, y1 - y0 + 1)};
}

}  // namespace

StandingLight::StandingLight(const Rect& region, const Picture& share)
    : region_(region), half_(share.width() / 2), share_(share), level_(region.width, region.height) {}

/// Sums over the windows of what is left unexplained at each pixel; sets the evidence.
void StandingLight::look(const std::vector<KeptWindow>& windows, const PartPictures& part, double inside) {
  sum_ = count_ = Picture(region_.width, region_.height);
  Picture squares = sum_;
  const QuinticSpline level(part.level);
  std::vector<float> shown;
  for (const KeptWindow& w : windows) {
    const LayeredState& s = w.state;
    const Rect face = about(s.centre, inside, w.x, w.y, w.picture);
    if (face.width == 0 || face.height == 0) continue;
    shown.resize(static_cast<std::size_t>(face.width) * static_cast<std::size_t>(face.height));
    const double u0 = face.x - s.centre.x, v0 = face.y - s.centre.y;
    level.sample_window(u0 + part.half, v0 + part.half, face.width, face.height, shown.data(), nullptr,
                        nullptr);
    for (int j = 0; j < face.height; ++j)
      for (int i = 0; i < face.width; ++i) {
        const double u = u0 + i, v = v0 + j;
        const int x = face.x + i - region_.x, y = face.y + j - region_.y;
        if (u * u + v * v > inside * inside || x < 0 || y < 0 || x >= region_.width || y >= region_.height)
          continue;
        const auto gain = static_cast<float>(s.gain * (1 + s.slope_x * u + s.slope_y * v));
        const float left = w.picture.at(face.x + i - w.x, face.y + j - w.y) -
                           gain * shown[static_cast<std::size_t>(j) * static_cast<std::size_t>(face.width) +
                                        static_cast<std::size_t>(i)];
        sum_.at(x, y) += left;
        squares.at(x, y) += left * left;
        count_.at(x, y) += 1;
      }
  }
  double between = 0, places = 0, within = 0, frames = 0;
  for (std::size_t i = 0; i < sum_.levels().size(); ++i) {
    const double n = count_.levels()[i];
    if (n < kFewest) continue;
    const double stands = static_cast<double>(sum_.levels()[i]) * sum_.levels()[i] / n;
    between += stands;
    within += squares.levels()[i] - stands;
    ++places;
    frames += n - 1;
  }
  evidence_ = within > 0 ? (between / places) / (within / frames) : 1;
}

void StandingLight::learn(std::vector<KeptWindow>& windows, const PartPictures& part, double inside) {
  look(windows, part, inside);
  const Picture more = smooth_plane(sum_, count_);
  for (std::size_t i = 0; i < more.levels().size(); ++i) level_.levels()[i] += more.levels()[i];
  for (KeptWindow& w : windows) {
    take_out(more, w.picture, w.x, w.y, w.state.centre);
    w.spline = QuinticSpline(w.picture);
  }
}

void StandingLight::take_out(const Picture& light, Picture& picture, int x, int y,
                             const Point& centre) const {
  const Rect grid = about(centre, half_ - 2, x, y, picture);
  if (grid.width == 0 || grid.height == 0) return;
  std::vector<float> ground(static_cast<std::size_t>(grid.width) * static_cast<std::size_t>(grid.height));
  share_.sample_window(grid.x - centre.x + half_, grid.y - centre.y + half_, grid.width, grid.height,
                       ground.data(), nullptr, nullptr);
  for (int j = 0; j < grid.height; ++j)
    for (int i = 0; i < grid.width; ++i) {
      const int at_x = grid.x + i - region_.x, at_y = grid.y + j - region_.y;
      if (at_x < 0 || at_y < 0 || at_x >= region_.width || at_y >= region_.height) continue;
      const float covers = 1 - ground[static_cast<std::size_t>(j) * static_cast<std::size_t>(grid.width) +
                                      static_cast<std::size_t>(i)];
      picture.at(grid.x + i - x, grid.y + j - y) -= covers * light.at(at_x, at_y);
    }
}

}  // namespace tribotrack::vision
