#include "vision/layers/model/light.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <stdexcept>

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

}  // namespace tribotrack::vision
