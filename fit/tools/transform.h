// Unbounded axes for the optimiser: bounds make Ceres start or end on them and stay there.
#pragma once

#include <algorithm>
#include <cmath>

namespace tribotrack::fit::internal {

// clang-format off
/// z <-> value on the whole real line.
///   linear     value = unit z                     angles, tilts, velocities; the lag is not wrapped
///   logarithm  value = exp(z)                     mu1, A, w, scale
///   hyperbola  value = unit (z + sqrt(z^2 + 1))   mu2: linear far from 0, never negative; unlike a logarithm it
///                                                 keeps a slope near 0, so that a long step towards 0 is no trap
// clang-format on
class Transform {
 public:
  enum class Kind { linear, logarithm, hyperbola };
  Transform(Kind kind, double unit) : kind_(kind), unit_(unit) {}

  double value(double z) const {
    if (kind_ == Kind::linear) return unit_ * z;
    if (kind_ == Kind::logarithm) return std::exp(std::clamp(z, -60.0, 60.0));
    // z + sqrt(z^2 + 1) without cancellation where z < 0.
    return unit_ * (z > 0 ? z + std::hypot(z, 1.0) : 1 / (std::hypot(z, 1.0) - z));
  }
  double z(double value) const {
    if (kind_ == Kind::linear) return value / unit_;
    if (kind_ == Kind::logarithm) return std::log(std::max(value, 1e-26));
    const double ratio = std::max(value / unit_, 1e-6);
    return 0.5 * (ratio - 1 / ratio);
  }
  /// d value / dz
  double slope(double z) const {
    if (kind_ == Kind::linear) return unit_;
    return kind_ == Kind::logarithm ? value(z) : value(z) / std::hypot(z, 1.0);
  }
  bool positive() const { return kind_ != Kind::linear; }

 private:
  Kind kind_;
  double unit_;
};

}  // namespace tribotrack::fit::internal
