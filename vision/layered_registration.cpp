#include "vision/layered_registration.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace tribotrack::vision {
namespace {

constexpr int kBorder = 1;              ///< px beyond the rim's reach: the ground's own level is learnt there
constexpr double kTurnTolerance = 0.1;  ///< px at the rim: further the disc's picture is turned anew
constexpr double kTolerance = 1e-4;     ///< px
constexpr double kMaxMove = 2;          ///< px from the start
constexpr int kMaxIterations = 12;
constexpr double kTrim = 5;  ///< sd: a pixel further off is something else (dust, glare, a lamp)
constexpr double kMaxTrim = 0.2;
constexpr double kLeastRim = 0.6;  ///< share of the rim that must be in the picture over known ground

using MapConst = Eigen::Map<const Eigen::VectorXf>;

enum Column { kX, kY, kGain, kSlopeX, kSlopeY, kGround, kTheta };

}  // namespace

LayeredRegistration::LayeredRegistration(const LayeredDisc& disc, const GroundPicture& ground)
    : disc_(disc), ground_(ground) {
  reach_ = static_cast<int>(std::ceil(disc.rim().outer())) + kBorder;
  const auto n = static_cast<std::size_t>(2 * reach_ + 1) * (2 * reach_ + 1);
  for (auto* v : {&level_, &weight_, &below_, &known_, &disc_level_, &disc_x_, &disc_y_, &disc_theta_,
                  &see_through_, &see_x_, &see_y_, &residual_, &predicted_, &u_, &v_, &rho_})
    v->assign(n, 0);
  jacobian_.resize(static_cast<Eigen::Index>(n), disc.turning() ? 7 : 6);
  disc_changed();
}

void LayeredRegistration::disc_changed() {
  share_ = QuinticSpline(disc_.share());
  cached_theta_ = 1e9;
  if (!disc_.turning()) standing_ = QuinticSpline(disc_.at(0));
}

void LayeredRegistration::turn_to(double theta) {
  if (!disc_.turning() || std::abs(theta - cached_theta_) * disc_.radius() < kTurnTolerance) return;
  Picture slope;
  standing_ = QuinticSpline(disc_.at(theta, &slope));
  slope_theta_ = QuinticSpline(slope);
  cached_theta_ = theta;
}

/// Layers under the window at a state.
void LayeredRegistration::form(const LayeredState& state, bool slopes) {
  const int size = 2 * reach_ + 1;
  const double left = x0_ - state.centre.x + disc_.half();
  const double top = y0_ - state.centre.y + disc_.half();
  standing_.sample_window(left, top, size, size, disc_level_.data(), slopes ? disc_x_.data() : nullptr,
                          slopes ? disc_y_.data() : nullptr);
  share_.sample_window(left, top, size, size, see_through_.data(), slopes ? see_x_.data() : nullptr,
                       slopes ? see_y_.data() : nullptr);
  if (disc_.turning()) {
    if (slopes) slope_theta_.sample_window(left, top, size, size, disc_theta_.data(), nullptr, nullptr);
    const auto turn = static_cast<float>(state.theta - cached_theta_);
    for (std::size_t i = 0; i < disc_level_.size(); ++i) disc_level_[i] += turn * disc_theta_[i];
  }
  const auto gain = static_cast<float>(state.gain);
  const auto qx = static_cast<float>(state.gain * state.slope_x);
  const auto qy = static_cast<float>(state.gain * state.slope_y);
  const auto under = static_cast<float>(state.ground_gain);
  for (std::size_t i = 0; i < residual_.size(); ++i) {
    predicted_[i] = (gain + qx * u_[i] + qy * v_[i]) * disc_level_[i] + under * see_through_[i] * below_[i];
    residual_[i] = level_[i] - predicted_[i];
  }
  if (!slopes) return;
  const auto n = static_cast<Eigen::Index>(residual_.size());
  float* jx = jacobian_.col(kX).data();
  float* jy = jacobian_.col(kY).data();
  float* ja = jacobian_.col(kGain).data();
  float* jqx = jacobian_.col(kSlopeX).data();
  float* jqy = jacobian_.col(kSlopeY).data();
  float* jb = jacobian_.col(kGround).data();
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const float light = gain + qx * u_[k] + qy * v_[k];
    jx[i] = -light * disc_x_[k] - under * below_[k] * see_x_[k];
    jy[i] = -light * disc_y_[k] - under * below_[k] * see_y_[k];
    ja[i] = disc_level_[k];
    jqx[i] = u_[k] * disc_level_[k];
    jqy[i] = v_[k] * disc_level_[k];
    jb[i] = see_through_[k] * below_[k];
  }
  if (disc_.turning()) {
    float* jt = jacobian_.col(kTheta).data();
    for (Eigen::Index i = 0; i < n; ++i)
      jt[i] = static_cast<float>(gain) * disc_theta_[static_cast<std::size_t>(i)];
  }
}

std::optional<LayeredFix> LayeredRegistration::refine(const Picture& picture, int x, int y,
                                                      const LayeredState& start, const LightPrior& prior) {
  const int size = 2 * reach_ + 1;
  x0_ = static_cast<int>(std::lround(start.centre.x)) - reach_;
  y0_ = static_cast<int>(std::lround(start.centre.y)) - reach_;
  ground_.sample(x0_ - start.ground.x, y0_ - start.ground.y, size, size, below_.data(), known_.data());
  turn_to(start.theta);

  const double inner = disc_.rim().inner();
  const double outer = disc_.rim().outer() + kBorder;
  double rim = 0;
  double rim_seen = 0;
  double pixels = 0;
  for (int j = 0; j < size; ++j)
    for (int i = 0; i < size; ++i) {
      const auto k = static_cast<std::size_t>(j) * size + i;
      const int px = x0_ + i - x;
      const int py = y0_ + j - y;
      u_[k] = static_cast<float>(x0_ + i - start.centre.x);
      v_[k] = static_cast<float>(y0_ + j - start.centre.y);
      rho_[k] = std::hypot(u_[k], v_[k]);
      weight_[k] = 0;
      level_[k] = 0;
      if (rho_[k] > outer) continue;
      const bool on_rim = rho_[k] > inner;
      rim += on_rim;
      if (px < 0 || py < 0 || px >= picture.width() || py >= picture.height()) continue;
      level_[k] = picture.at(px, py);
      if (on_rim && known_[k] == 0) continue;
      rim_seen += on_rim;
      weight_[k] = 1;
      ++pixels;
    }
  if (rim_seen < kLeastRim * rim) return std::nullopt;

  LayeredFix fix;
  fix.state = start;
  LayeredState& s = fix.state;
  form(s, true);
  for (std::size_t i = 0; i < weight_.size(); ++i)
    if (weight_[i] > 0) weight_[i] = static_cast<float>(1 / noise_.at(predicted_[i]));
  const auto n = static_cast<Eigen::Index>(weight_.size());
  const double hold = prior.sd > 0 ? 1 / (prior.sd * prior.sd) : 0;
  Eigen::MatrixXd normal;
  Eigen::LDLT<Eigen::MatrixXd> factor;
  const auto factorise = [&] {
    const Eigen::MatrixXf weighted = MapConst(weight_.data(), n).asDiagonal() * jacobian_;
    normal = (weighted.transpose() * jacobian_).cast<double>();
    normal(kSlopeX, kSlopeX) += hold;
    normal(kSlopeY, kSlopeY) += hold;
    factor.compute(normal);
  };
  factorise();
  bool trimmed = false;
  bool converged = false;
  for (int iteration = 0; iteration < kMaxIterations && !converged; ++iteration) {
    const Eigen::VectorXf weighted = MapConst(weight_.data(), n).cwiseProduct(MapConst(residual_.data(), n));
    Eigen::VectorXd force = (jacobian_.transpose() * weighted).cast<double>();
    force(kSlopeX) += hold * s.gain * (prior.slope_x - s.slope_x);
    force(kSlopeY) += hold * s.gain * (prior.slope_y - s.slope_y);
    const Eigen::VectorXd step = factor.solve(force);
    if (!step.allFinite()) return std::nullopt;
    const double length = std::hypot(step(kX), step(kY));
    const double brake = length > 1 ? 1 / length : 1;
    s.centre.x += brake * step(kX);
    s.centre.y += brake * step(kY);
    const double qx = s.gain * s.slope_x + brake * step(kSlopeX);
    const double qy = s.gain * s.slope_y + brake * step(kSlopeY);
    s.gain += brake * step(kGain);
    s.ground_gain += brake * step(kGround);
    if (s.gain < 0.05) return std::nullopt;
    s.slope_x = qx / s.gain;
    s.slope_y = qy / s.gain;
    if (disc_.turning()) s.theta += std::clamp(brake * step(kTheta), -0.2, 0.2);
    if (std::hypot(s.centre.x - start.centre.x, s.centre.y - start.centre.y) > kMaxMove) return std::nullopt;
    const bool settled = length < kTolerance;
    const bool re_form = length > 0.15;
    form(s, re_form || (settled && !trimmed));
    if (settled && !trimmed) {
      trimmed = true;
      double count = 0;
      for (std::size_t i = 0; i < weight_.size(); ++i)
        if (weight_[i] > 0 && residual_[i] * residual_[i] * weight_[i] > kTrim * kTrim) {
          weight_[i] = 0;
          ++count;
        }
      fix.trimmed_share = count / pixels;
      if (fix.trimmed_share > kMaxTrim) return std::nullopt;
      factorise();
      converged = count == 0;
    } else if (settled) {
      converged = true;
    } else if (re_form) {
      factorise();
    }
  }
  if (!converged) return std::nullopt;
  const Eigen::MatrixXd inverse = normal.inverse();
  fix.covariance = inverse.topLeftCorner<2, 2>();
  fix.sigma_slope = std::sqrt(0.5 * (inverse(kSlopeX, kSlopeX) + inverse(kSlopeY, kSlopeY))) / s.gain;

  double seen = 0, rim_pixels = 0, sum_i = 0, sum_p = 0, ii = 0, pp = 0, ip = 0;
  for (std::size_t i = 0; i < weight_.size(); ++i) {
    if (weight_[i] == 0) continue;
    const double chi = static_cast<double>(weight_[i]) * residual_[i] * residual_[i];
    ++seen;
    fix.chi_squared += chi;
    const double a = level_[i];
    const double b = predicted_[i];
    sum_i += a, sum_p += b, ii += a * a, pp += b * b, ip += a * b;
    if (rho_[i] <= inner || rho_[i] >= disc_.rim().outer()) continue;
    ++rim_pixels;
    fix.rim_chi_squared += chi;
  }
  fix.chi_squared /= std::max(1.0, seen - static_cast<double>(jacobian_.cols()));
  fix.rim_chi_squared /= std::max(1.0, rim_pixels);
  const double variances = (ii - sum_i * sum_i / seen) * (pp - sum_p * sum_p / seen);
  fix.ncc = variances > 0 ? (ip - sum_i * sum_p / seen) / std::sqrt(variances) : 0;
  return fix;
}

void LayeredRegistration::add_residuals(LevelSums& sums) const {
  for (std::size_t i = 0; i < weight_.size(); ++i) {
    if (weight_[i] == 0) continue;
    if (rho_[i] > disc_.rim().inner() && rho_[i] < disc_.rim().outer()) continue;
    const double level = predicted_[i];
    const double square = static_cast<double>(residual_[i]) * residual_[i];
    sums.n += 1;
    sums.level += level;
    sums.level_level += level * level;
    sums.square += square;
    sums.level_square += level * square;
  }
}

}  // namespace tribotrack::vision
