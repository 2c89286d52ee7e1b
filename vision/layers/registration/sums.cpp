// What a registered frame tells of the noise, the rim and the ground, for those who learn them.
#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <vector>

#include "vision/layers/registration/registration.h"

namespace tribotrack::vision {
namespace {

constexpr double kSureGround = 0.1;  ///< variance of the ground that does not spoil the noise law
constexpr double kLeastLean = 1e-4;  ///< of a rim pixel's share in the information: not worth a sum

}  // namespace

GroundLean LayeredRegistration::lean(const LayeredFix& fix) const {
  GroundLean out;
  out.information = fix.covariance.inverse();
  const Rect& region = ground_.region();
  const int left = static_cast<int>(std::lround(x0_ - fix.state.ground.x)) - region.x;
  const int top = static_cast<int>(std::lround(y0_ - fix.state.ground.y)) - region.y;
  const auto under = static_cast<float>(light_.ground);
  const auto least = static_cast<float>(kLeastLean * out.information.trace() / std::max(1.0, rim_pixels_));
  for (std::size_t i = 0; i < mask_.size(); ++i) {
    const float through = under * arrays_.share.value[i] * arrays_.weight[i];
    const float x = through * arrays_.step_x[i], y = through * arrays_.step_y[i];
    if ((x * x + y * y) * arrays_.ground_variance[i] < least) continue;
    const int u = left + static_cast<int>(arrays_.u[i]), v = top + static_cast<int>(arrays_.v[i]);
    if (u < 0 || v < 0 || u >= region.width || v >= region.height) continue;
    out.pulls.push_back({static_cast<std::uint32_t>(v * region.width + u), x, y});
  }
  return out;
}

void LayeredRegistration::add_rim(RimSums& sums) const {
  const LayerRimSums here = layer_kernels_.rim(arrays_, counts_, light_, ground_.mean());
  sums.qr += here.qr;
  sums.qq += here.qq;
  const auto& [xx, xy, yy] = here.shift_normal;
  sums.shift_normal += Eigen::Matrix2d{{xx, xy}, {xy, yy}};
  sums.shift_force += Eigen::Vector2d(here.shift_force[0], here.shift_force[1]);
  Eigen::MatrixXd mixed = Eigen::MatrixXd::Zero(columns(), 2);
  for (Eigen::Index c = 0; c < mixed.rows(); ++c) {
    const auto& [on_x, on_y] = here.mixed[static_cast<std::size_t>(c)];
    mixed.row(c) << on_x, on_y;
  }
  sums.shift_normal -= mixed.transpose() * Eigen::LDLT<Matrix>(normal_).solve(mixed);
}

/// Pixels of the tiles on either side of the rim. Where the ground has no texture its light is told from the
/// disc's rim only: outside, it is what the pixels there say.
void LayeredRegistration::add_residuals(LevelSums& sums) const {
  const double inner = disc_.rim().inner(), outer = disc_.rim().outer();
  struct Seen {
    double level, residual, below, sure;
  };
  std::vector<Seen> seen;
  double cross = 0, square_below = 0;
  for (std::size_t i = 0; i < mask_.size(); ++i) {
    if (!(arrays_.level[i] > 0) || (mask_[i] > 0 && counts_[i] == 0)) continue;
    const double u = arrays_.u[i], v = arrays_.v[i], rho_squared = u * u + v * v;
    const bool outside = rho_squared >= outer * outer;
    if (rho_squared > inner * inner && !outside) continue;
    if (outside && static_cast<double>(arrays_.ground_variance[i]) > kSureGround * noise_.constant) continue;
    const double r = residual(i, light_), below = outside ? static_cast<double>(arrays_.ground.value[i]) : 0;
    const double sure = out_of_picture_ ? precision(x0_ + static_cast<int>(u), y0_ + static_cast<int>(v)) : 1;
    seen.push_back({arrays_.level[i], r, below, sure});
    cross += r * below;
    square_below += below * below;
  }
  const double lit = square_below > 0 ? cross / square_below : 0;
  for (const Seen& s : seen) {
    const double r = s.residual - lit * s.below, level = s.level - r, square = s.sure * r * r;
    if (square > kTrim * kTrim * noise_.at(level)) continue;
    sums.n += 1;
    sums.level += level;
    sums.level_level += level * level;
    sums.square += square;
    sums.level_square += level * square;
  }
}

}  // namespace tribotrack::vision
