// TemplateRegistration, template: set-up, which of its pixels take part, and its levels and slopes at any
// pose.
#include "vision/registration/registration.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "vision/kernels/plane.h"
#include "vision/registration/pattern.h"

namespace tribotrack::vision {

TemplateRegistration::TemplateRegistration(const Picture& first, const Pattern& pattern,
                                           const RegistrationOptions& options)
    : options_(options), pattern_(pattern) {
  const Rect& w = pattern.window;
  constexpr int kBorder = 12;  ///< context of the spline around the template, px
  const Rect context = grown(w, kBorder, bounds_of(first));
  spline_ = QuinticSpline(part_of(first, context));
  spline_x_ = context.x;
  spline_y_ = context.y;
  const Picture levels = part_of(first, w);
  double sum = 0;
  double squares = 0;
  for (int y = 0; y < w.height; ++y)
    for (int x = 0; x < w.width; ++x) {
      if (!(pattern.weights.at(x, y) > 0)) continue;
      ++area_;
      sum += levels.at(x, y);
      squares += static_cast<double>(levels.at(x, y)) * levels.at(x, y);
    }
  pivot_ = static_cast<float>(sum / area_);
  contrast_ = std::sqrt(std::max(0.0, squares / area_ - (sum / area_) * (sum / area_)));
  choose_pixels();
  const bool rotation = options_.rotation;
  options_.rotation = false;
  take_picture(levels, w.x, w.y, 0, 0);
  sample_template({}, true);
  const Matrix normal = normal_matrix(), honest = debiased(normal, {});
  limit_ = options_.noise_variance * inverse_of(honest).topLeftCorner<2, 2>();
  template_noise_cost_ =
      (normal - honest).topLeftCorner<2, 2>().trace() / honest.topLeftCorner<2, 2>().trace();
  options_.rotation = rotation;
  if (rotation) arrays_.slope_theta.resize(mask_.size());
}

/// Samples every pixel of the template once, then keeps the informative ones.
void TemplateRegistration::choose_pixels() {
  const Rect& w = pattern_.window;
  Picture value(w.width, w.height), slope_x(w.width, w.height), slope_y(w.width, w.height);
  spline_.sample_window(w.x - spline_x_, w.y - spline_y_, w.width, w.height, value.levels().data(),
                        slope_x.levels().data(), slope_y.levels().data());
  const double noise_square = 2 * template_noise() * quintic_noise(0).slope * quintic_noise(0).value;
  const Picture mask = informative_pixels(slope_x, slope_y, pattern_.weights, noise_square);
  places_ = cover_with_tiles(mask);
  mask_ = under_tiles(mask, places_);
  pixels_ = static_cast<double>(std::ranges::count_if(mask_, [](float m) { return m > 0; }));
  arrays_.resize(places_.size());
  corners_.resize(places_.size());
}

/// T and, on request, its derivatives with respect to the pose, at every pixel of the tiles.
void TemplateRegistration::sample_template(const Pose& fraction, bool slopes) {
  if (options_.rotation) return sample_turned(fraction, slopes);
  const double x = pattern_.window.x - spline_x_ - fraction.dx;
  const double y = pattern_.window.y - spline_y_ - fraction.dy;
  spline_.sample_tiles(x, y, places_, corners_, pivot_, slopes, arrays_);
}

/// Every pixel has a fraction of its own.
void TemplateRegistration::sample_turned(const Pose& fraction, bool slopes) {
  // Counter-clockwise with y up is, in pixels with y down, (x, y) -> (c x + s y, -s x + c y).
  const auto c = static_cast<float>(std::cos(fraction.theta)),
             s = static_cast<float>(std::sin(fraction.theta));
  // From the pattern's centre, and where that is in the spline.
  const double from_x = pattern_.window.x - pattern_.centre.x - fraction.dx,
               from_y = pattern_.window.y - pattern_.centre.y - fraction.dy;
  const auto centre_x = static_cast<float>(pattern_.centre.x - spline_x_),
             centre_y = static_cast<float>(pattern_.centre.y - spline_y_);
  turned_x_.resize(mask_.size());
  turned_y_.resize(mask_.size());
  for (std::size_t t = 0; t < places_.size(); ++t)
    for (int j = 0; j < kTile; ++j)
      for (int i = 0; i < kTile; ++i) {
        const std::size_t k = t * kTilePixels + static_cast<std::size_t>(j * kTile + i);
        const auto rx = static_cast<float>(from_x + places_[t].x + i);
        const auto ry = static_cast<float>(from_y + places_[t].y + j);
        turned_x_[k] = centre_x + (c * rx - s * ry);  // back into the template
        turned_y_[k] = centre_y + (s * rx + c * ry);
      }
  spline_.sample_places(turned_x_, turned_y_, arrays_.value.data(), slopes ? arrays_.slope_x.data() : nullptr,
                        arrays_.slope_y.data());
  for (float& value : arrays_.value) value -= pivot_;
  if (!slopes) return;
  for (std::size_t k = 0; k < mask_.size(); ++k) {
    const float tx = arrays_.slope_x[k], ty = arrays_.slope_y[k];
    arrays_.slope_x[k] = c * tx + s * ty;
    arrays_.slope_y[k] = c * ty - s * tx;
    arrays_.slope_theta[k] = ty * (turned_x_[k] - centre_x) - tx * (turned_y_[k] - centre_y);
  }
}

Picture TemplateRegistration::at(const Pose& pose, const Rect& window) const {
  Picture out(window.width, window.height);
  const double c = std::cos(pose.theta);
  const double s = std::sin(pose.theta);
  for (int y = 0; y < window.height; ++y)
    for (int x = 0; x < window.width; ++x) {
      const double rx = x + window.x - (pattern_.centre.x + pose.dx);
      const double ry = y + window.y - (pattern_.centre.y + pose.dy);
      out.at(x, y) = static_cast<float>(spline_.value(pattern_.centre.x + c * rx - s * ry - spline_x_,
                                                      pattern_.centre.y + s * rx + c * ry - spline_y_));
    }
  return out;
}

// TemplateRegistration, picture: grey levels and weights under the template at a pose.

/// Grey levels under the tiles moved by whole pixels; weight 0 outside the picture. False where less than
/// half of the mask is covered.
bool TemplateRegistration::take_picture(const Picture& picture, int x, int y, int whole_x, int whole_y) {
  const Rect& w = pattern_.window;
  base_weight_ = mask_;
  const bool all_inside = take_levels(picture, w.x + whole_x - x, w.y + whole_y - y, places_, pivot_,
                                      arrays_.level, base_weight_);
  arrays_.weight = base_weight_;
  if (all_inside) return true;
  double covered = 0;
  for (const float weight : base_weight_) covered += weight;
  return covered > 0.5 * pixels_;
}

// TemplateRegistration, noise: what the template's own noise does to the normal equations.

/// The noise of the template adds its own slopes to the derivatives: sum (g + e)^2 = sum g^2 + sum e^2.
TemplateRegistration::Matrix TemplateRegistration::debiased(const Matrix& normal,
                                                            const Pose& fraction) const {
  const InterpolationNoise nx = quintic_noise(-fraction.dx), ny = quintic_noise(-fraction.dy);
  Matrix out = normal;
  const double noise = template_noise() * normal(3, 3);  // sum of the weights
  out(0, 0) -= std::min(0.7 * normal(0, 0), noise * nx.slope * ny.value);
  out(1, 1) -= std::min(0.7 * normal(1, 1), noise * nx.value * ny.slope);
  return out;
}

/// Noise variance that would explain the present residual, picture and template noisy alike.
double TemplateRegistration::residual_noise(const ForceSums& sums, const Pose& at, double gain) const {
  return sums.squares / std::max(1.0, sums.weight - columns()) /
         (1 + options_.template_noise_share * gain * gain * quintic_noise(at.dx).value *
                  quintic_noise(at.dy).value);
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
  const InterpolationNoise x = quintic_noise(-formed.dx, -at.dx);
  const InterpolationNoise y = quintic_noise(-formed.dy, -at.dy);
  const double z = 2 * std::numbers::pi * pattern_.reach() * std::abs(at.theta);
  const double mixing = z > 1e-3 ? (z < 30 ? 2 * std::cyl_bessel_j(1.0, z) / z : 0) : 1;
  return mixing * gain * options_.template_noise_share * noise * sums.weight *
         Eigen::Vector2d(x.slope_value * y.value, x.value * y.slope_value);
}

}  // namespace tribotrack::vision
