// TemplateRegistration, iteration: Gauss-Newton from a start to the pose, its score and its covariance.
#include "vision/registration/registration.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "vision/kernels/median.h"

namespace tribotrack::vision {

TemplateRegistration::Matrix TemplateRegistration::normal_matrix() const {
  return symmetric(normal_sums(arrays_), columns());
}

Registration TemplateRegistration::refine(const Picture& picture, int x, int y, const Pose& start) {
  Registration out;
  out.pose = start;
  int whole_x = static_cast<int>(std::lround(start.dx));
  int whole_y = static_cast<int>(std::lround(start.dy));
  Pose fraction{start.dx - whole_x, start.dy - whole_y, start.theta};
  if (!take_picture(picture, x, y, whole_x, whole_y)) return out;
  sample_template(fraction, true);
  Pose formed = fraction;  // where the derivatives belong to
  Matrix normal = normal_matrix();
  FewFactor factor(normal);
  double gain = 1;
  double offset = 0;
  const double noise_sd = std::sqrt(options_.noise_variance);
  constexpr int kMostIterations = 20;
  constexpr double kFarthest = 4;      ///< px from the start: further is no convergence
  constexpr double kTolerance = 1e-4;  ///< px
  bool trimmed = false;
  const auto sums_now = [&] {
    return force_sums(arrays_, static_cast<float>(gain), static_cast<float>(offset));
  };
  for (int iteration = 0; iteration < kMostIterations; ++iteration) {
    const ForceSums sums = sums_now();
    Vector force = Eigen::Map<const Eigen::Matrix<double, 5, 1>>(sums.force.data()).head(columns());
    force.head<2>() -= noise_force(sums, formed, fraction, gain);
    const Vector step = factor.solve(force);
    if (!step.allFinite()) return out;
    gain += step(2);
    offset += step(3);
    if (gain < 0.02) return out;
    double move_x = step(0) / gain;
    double move_y = step(1) / gain;
    const double length = std::hypot(move_x, move_y);
    const double brake = length > 1 ? 1 / length : 1;  // the linearisation is good for a pixel at most
    fraction.dx += brake * move_x;
    fraction.dy += brake * move_y;
    double turn = 0;
    if (options_.rotation) {
      turn = std::clamp(step(4) / gain, -0.2, 0.2);
      fraction.theta += turn;
    }
    if (std::hypot(whole_x + fraction.dx - start.dx, whole_y + fraction.dy - start.dy) > kFarthest)
      return out;
    const double turn_px = std::abs(turn) * pattern_.reach();
    bool settled = length < kTolerance && turn_px < 10 * kTolerance;
    const bool re_centre = std::abs(fraction.dx) > 0.75 || std::abs(fraction.dy) > 0.75;
    if (re_centre) {
      const int sx = static_cast<int>(std::lround(fraction.dx));
      const int sy = static_cast<int>(std::lround(fraction.dy));
      whole_x += sx;
      whole_y += sy;
      fraction.dx -= sx;
      fraction.dy -= sy;
      if (!take_picture(picture, x, y, whole_x, whole_y)) return out;
      trimmed = false;
    }
    const bool re_form = re_centre || std::hypot(fraction.dx - formed.dx, fraction.dy - formed.dy) > 0.15 ||
                         std::abs(fraction.theta - formed.theta) * pattern_.reach() > 0.5;
    if (re_form || !settled) sample_template(fraction, re_form);
    if (settled && !trimmed) {
      trimmed = true;
      if (trim(sums_now(), gain, offset, noise_sd) > 0) {
        factor.compute(normal = normal_matrix());
        settled = false;
      }
    }
    if (settled) {
      out.converged = true;
      break;
    }
    if (re_form) {
      formed = fraction;
      factor.compute(normal = normal_matrix());
    }
  }
  out.pose = {whole_x + fraction.dx, whole_y + fraction.dy, fraction.theta};
  out.gain = gain;
  out.offset = offset + pivot_ - gain * pivot_;
  out.ncc = correlation_sums(arrays_, base_weight_).correlation();
  if (!out.converged) return out;

  const ForceSums sums = sums_now();
  out.residual_rms = std::sqrt(sums.squares / std::max(1.0, sums.weight - columns()));

  // A residual clearly below the estimated noise (a texture passed for noise) is the better estimate; nearly
  // none is the template met again in its own frame.
  const double shown = residual_noise(sums, fraction, gain);
  const bool quieter = shown < 0.8 * options_.noise_variance && shown > 0.1 * options_.noise_variance;
  const double noise = quieter ? std::max(shown, 1.0 / 12) : options_.noise_variance;
  const Matrix inverse = inverse_of(debiased(normal, fraction));
  const Matrix spread = inverse * normal * inverse / (gain * gain);
  out.covariance = noise * spread.topLeftCorner<2, 2>();
  found_ = {gain, offset, noise, noise_force(sums, formed, fraction, gain), out.covariance};
  if (options_.rotation) out.sigma_theta = std::sqrt(noise * spread(4, 4));

  // Residual beyond noise: something in the picture that the model does not have.
  const double expected = out.residual_rms * out.residual_rms * std::min(1.0, noise / shown);
  const double excess = out.residual_rms * out.residual_rms - expected;
  // Four times the scatter of a variance estimate, and a tenth for noise that is not quite white.
  const double tolerated = expected * (0.1 + 4 * std::sqrt(2 / std::max(1.0, sums.weight)));
  if (excess <= tolerated) return out;
  out.excess_rms = std::sqrt(excess);
  const double share = excess / (excess + expected);
  const Eigen::Matrix3d robust = sandwich(inverse, gain, offset);
  out.covariance += share * robust.topLeftCorner<2, 2>();
  if (options_.rotation)
    out.sigma_theta = std::sqrt(out.sigma_theta * out.sigma_theta + share * robust(2, 2));
  return out;
}

double TemplateRegistration::score(const Picture& picture, int x, int y, const Pose& pose) {
  const int whole_x = static_cast<int>(std::lround(pose.dx));
  const int whole_y = static_cast<int>(std::lround(pose.dy));
  if (!take_picture(picture, x, y, whole_x, whole_y)) return 0;
  sample_template({pose.dx - whole_x, pose.dy - whole_y, pose.theta}, false);
  return correlation_sums(arrays_, base_weight_).correlation();
}

// TemplateRegistration, robustness: pixels that do not belong to the template (glare, a hand) are trimmed,
// and what the template does not explain enters the covariance.

/// Sets the weight of pixels to zero whose residual cannot be noise. Returns how many.
std::size_t TemplateRegistration::trim(const ForceSums& sums, double gain, double offset, double noise_sd) {
  const double least = std::max(6 * noise_sd, 0.5 * std::abs(gain) * contrast_);
  if (sums.largest <= least) return 0;
  std::vector<float> residual(mask_.size()), sizes;
  for (std::size_t i = 0; i < mask_.size(); ++i) {
    if (!(base_weight_[i] > 0)) continue;
    residual[i] =
        std::abs(arrays_.level[i] - static_cast<float>(gain) * arrays_.value[i] - static_cast<float>(offset));
    sizes.push_back(residual[i]);
  }
  constexpr double kUsual = 4 * kNormalMad;  ///< median sizes of the residual
  const double limit = std::max(least, kUsual * static_cast<double>(median(sizes)));
  std::vector<unsigned char> outliers(mask_.size());
  for (std::size_t i = 0; i < mask_.size(); ++i) outliers[i] = static_cast<double>(residual[i]) > limit;
  // A texture that has turned does not match anywhere until its angle is found.
  const std::size_t count = leave_out(places_, std::move(outliers), !options_.rotation, arrays_.weight);
  constexpr double kMaxTrim = 0.4;  ///< a larger share of outliers: it is not the template
  if (static_cast<double>(count) > kMaxTrim * static_cast<double>(sizes.size())) {
    arrays_.weight = base_weight_;
    return 0;
  }
  return count;
}

/// Sandwich covariance of (dx, dy, theta) with the tiles as clusters.
Eigen::Matrix3d TemplateRegistration::sandwich(const Matrix& inverse, double gain, double offset) {
  Eigen::Matrix<double, 5, 5> meat = Eigen::Matrix<double, 5, 5>::Zero();
  for (std::size_t t = 0; t < places_.size(); ++t) {
    const ForceSums of_tile =
        force_sums(arrays_, static_cast<float>(gain), static_cast<float>(offset), t, t + 1);
    const Eigen::Map<const Eigen::Matrix<double, 5, 1>> score(of_tile.force.data());
    meat += score * score.transpose();
  }
  const Matrix covariance = inverse * meat.topLeftCorner(columns(), columns()) * inverse / (gain * gain);
  Eigen::Matrix3d out = Eigen::Matrix3d::Zero();
  out.topLeftCorner<2, 2>() = covariance.topLeftCorner<2, 2>();
  if (options_.rotation) out(2, 2) = covariance(4, 4);
  return out;
}

// TemplateRegistration, audit: what each tile has to say at the pose found.

std::optional<HalvesError> TemplateRegistration::halves() const {
  const std::vector<TileSums> tiles = tile_sums();
  if (tiles.empty()) return std::nullopt;
  Matrix normal = tiles.front().normal;
  for (std::size_t t = 1; t < tiles.size(); ++t) normal += tiles[t].normal;
  return halves_error(tiles, normal, found_.covariance);
}

/// Columns are x, y, gain, offset and, where it is estimated, rotation.
std::vector<TileSums> TemplateRegistration::tile_sums() const {
  const std::size_t tiles = places_.size();
  const int n = columns();
  const double weight = normal_matrix()(3, 3);

  // The kernels' slopes are those of the template, the picture's are gain times as steep.
  Vector slope = Vector::Ones(n);
  slope.head<2>().setConstant(found_.gain);
  if (options_.rotation) slope(4) = found_.gain;
  std::vector<TileSums> out(tiles);
  for (std::size_t t = 0; t < tiles; ++t) {
    const Matrix normal = symmetric(normal_sums(arrays_, t, t + 1), n);
    const ForceSums sums =
        force_sums(arrays_, static_cast<float>(found_.gain), static_cast<float>(found_.offset), t, t + 1);
    Vector score = Eigen::Map<const Eigen::Matrix<double, 5, 1>>(sums.force.data()).head(n);
    // The known force of the template's noise: at the optimum it is what the scores add up to.
    score.head<2>() -= normal(3, 3) / weight * found_.noise_force;
    constexpr double kMiddle = 0.5 * (kTile - 1);
    out[t].place = {pattern_.window.x + places_[t].x + kMiddle - pattern_.centre.x,
                    pattern_.window.y + places_[t].y + kMiddle - pattern_.centre.y};
    out[t].score = slope.cwiseProduct(score) / found_.noise;
    out[t].normal = slope.asDiagonal() * normal * slope.asDiagonal() / found_.noise;
  }
  return out;
}

}  // namespace tribotrack::vision
