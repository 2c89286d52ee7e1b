// TemplateRegistration, noise: what the template's own noise does to the normal equations.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "vision/registration/registration.h"

namespace tribotrack::vision {

/// The noise of the template adds its own slopes to the derivatives: sum (g + e)^2 = sum g^2 + sum e^2.
TemplateRegistration::Matrix TemplateRegistration::debiased(const Matrix& normal,
                                                            const Pose& fraction) const {
  const auto gain = [&](double f) {
    const double t = (f - std::floor(f)) * kFractions;
    return noise_gain_[static_cast<std::size_t>(std::lround(t))];
  };
  const InterpolationNoise nx = gain(-fraction.dx);
  const InterpolationNoise ny = gain(-fraction.dy);
  Matrix out = normal;
  const double noise = template_noise() * normal(3, 3);  // sum of the weights
  out(0, 0) -= std::min(0.7 * normal(0, 0), noise * nx.slope * ny.value);
  out(1, 1) -= std::min(0.7 * normal(1, 1), noise * nx.value * ny.slope);
  return out;
}

/// Noise variance that would explain the present residual, picture and template noisy alike.
double TemplateRegistration::residual_noise(const ForceSums& sums, const Pose& at, double gain) const {
  const auto value_gain = [&](double f) {  // continuous, or the iteration could swing between two entries
    const double t = (f - std::floor(f)) * kFractions;
    const auto k = std::min(static_cast<std::size_t>(t), static_cast<std::size_t>(kFractions - 1));
    const double share = t - static_cast<double>(k);
    return (1 - share) * noise_gain_[k].value + share * noise_gain_[k + 1].value;
  };
  return sums.squares / std::max(1.0, sums.weight - columns()) /
         (1 + options_.template_noise_share * gain * gain * value_gain(at.dx) * value_gain(at.dy));
}

/// Expectation of sum w J r that is due to the template's noise alone: its slopes (in J, formed at one
/// fraction) and its values (in r, at another) are correlated. A turned template mixes all fractions, which
/// averages it out: 2 J1(z) / z for a disc.
Eigen::Vector2d TemplateRegistration::noise_force(const ForceSums& sums, const Pose& formed, const Pose& at,
                                                  double gain) const {
  // The noise cannot be more than what the residual shows; from clearly less to within its scatter, a ramp.
  const double shown = residual_noise(sums, at, gain);
  const double share = std::clamp((shown / options_.noise_variance - 0.6) / 0.2, 0.0, 1.0);
  const double noise =
      share * options_.noise_variance + (1 - share) * std::min(shown, options_.noise_variance);
  const InterpolationCovariance x = quintic_noise_covariance(-formed.dx, -at.dx);
  const InterpolationCovariance y = quintic_noise_covariance(-formed.dy, -at.dy);
  const double z = 2 * std::numbers::pi * pattern_.reach() * std::abs(at.theta);
  const double mixing = z > 1e-3 ? (z < 30 ? 2 * std::cyl_bessel_j(1.0, z) / z : 0) : 1;
  return mixing * gain * options_.template_noise_share * noise * sums.weight *
         Eigen::Vector2d(x.slope_value * y.value_value, x.value_value * y.slope_value);
}

}  // namespace tribotrack::vision
