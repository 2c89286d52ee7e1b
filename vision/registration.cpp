#include "vision/registration.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace tribotrack::vision {
namespace {

constexpr int kBorder = 12;       ///< context of the spline around the template, px
constexpr int kFractions = 16;    ///< table of interpolation noise
constexpr double kMaxTrim = 0.4;  ///< more than this share of strange pixels: it is not the template
constexpr int kBlock = 8;         ///< px, for the sandwich estimate

using MapConst = Eigen::Map<const Eigen::VectorXf>;

}  // namespace

TemplateRegistration::TemplateRegistration(const Picture& first, const Pattern& pattern,
                                           const RegistrationOptions& options)
    : options_(options), pattern_(pattern) {
  const Rect& w = pattern.window;
  const int x0 = std::max(0, w.x - kBorder);
  const int y0 = std::max(0, w.y - kBorder);
  const int x1 = std::min(first.width(), w.x + w.width + kBorder);
  const int y1 = std::min(first.height(), w.y + w.height + kBorder);
  Picture context(x1 - x0, y1 - y0);
  for (int y = y0; y < y1; ++y) std::copy_n(first.row(y).begin() + x0, x1 - x0, context.row(y - y0).begin());
  spline_ = QuinticSpline(context);
  spline_x_ = x0;
  spline_y_ = y0;
  levels_ = Picture(w.width, w.height);
  double sum = 0;
  double squares = 0;
  for (int y = 0; y < w.height; ++y)
    for (int x = 0; x < w.width; ++x) {
      const float level = first.at(w.x + x, w.y + y);
      levels_.at(x, y) = level;
      const double rho = std::hypot(w.x + x - pattern.centre.x, w.y + y - pattern.centre.y);
      if (pattern.weights.at(x, y) == 0 && rho < pattern.radius + 2) gaps_ = true;
      if (pattern.weights.at(x, y) > 0) {
        ++pixels_;
        sum += level;
        squares += static_cast<double>(level) * level;
      }
    }
  pivot_ = static_cast<float>(sum / pixels_);
  contrast_ = std::sqrt(std::max(0.0, squares / pixels_ - (sum / pixels_) * (sum / pixels_)));
  for (int k = 0; k <= kFractions; ++k)
    noise_gain_.push_back(quintic_noise(static_cast<double>(k) / kFractions));

  const auto n = levels_.levels().size();
  for (auto* v : {&level_, &base_weight_, &weight_, &value_, &slope_x_, &slope_y_, &slope_theta_, &residual_})
    v->resize(n);

  // The bound, from the template in its own place.
  const bool rotation = options_.rotation;
  options_.rotation = false;
  take_picture(levels_, w.x, w.y, 0, 0, 0);
  sample_template({}, true);
  const Eigen::MatrixXd normal = debiased(normal_matrix(), {});
  limit_ = options_.noise_variance * normal.inverse().topLeftCorner<2, 2>();
  double information = 0;
  double noise_information = 0;
  double count = 0;
  for (int y = 0; y < w.height; ++y)
    for (int x = 0; x < w.width; ++x) {
      const double rx = x + w.x - pattern.centre.x;
      const double ry = y + w.y - pattern.centre.y;
      const double rho_squared = rx * rx + ry * ry;
      if (pattern.weights.at(x, y) == 0) continue;
      if (pattern.radius > 0 && std::sqrt(rho_squared) > pattern.radius - 2.5) continue;
      const auto i = static_cast<std::size_t>(y) * w.width + x;
      const double slope = slope_x_[i] * -ry + slope_y_[i] * rx;
      information += slope * slope;
      noise_information += options_.noise_variance * noise_gain_[0].slope * rho_squared;
      ++count;
    }
  // The slopes of noise alone look like a texture: it must stand out from their scatter.
  information -= noise_information;
  const double visible = noise_information * std::max(0.5, 12 / std::sqrt(std::max(1.0, count)));
  limit_theta_ = information > visible ? std::sqrt(options_.noise_variance / information) : 1e9;
  options_.rotation = rotation;
}

/// T and, if asked, its derivatives with respect to the pose, at every pixel of the window.
void TemplateRegistration::sample_template(const Pose& fraction, bool slopes) {
  const Rect& w = pattern_.window;
  if (!options_.rotation) {
    spline_.sample_window(w.x - spline_x_ - fraction.dx, w.y - spline_y_ - fraction.dy, w.width, w.height,
                          value_.data(), slopes ? slope_x_.data() : nullptr,
                          slopes ? slope_y_.data() : nullptr);
    for (float& v : value_) v -= pivot_;
  } else {
    // Counter-clockwise with y up is, in pixels with y down, (x, y) -> (c x + s y, -s x + c y).
    const double c = std::cos(fraction.theta);
    const double s = std::sin(fraction.theta);
    for (int y = 0; y < w.height; ++y)
      for (int x = 0; x < w.width; ++x) {
        const auto i = static_cast<std::size_t>(y) * w.width + x;
        if (base_weight_[i] == 0) {
          value_[i] = slope_x_[i] = slope_y_[i] = slope_theta_[i] = 0;
          continue;
        }
        const double rx = x + w.x - pattern_.centre.x - fraction.dx;
        const double ry = y + w.y - pattern_.centre.y - fraction.dy;
        const double ux = c * rx - s * ry;  // back into the template
        const double uy = s * rx + c * ry;
        const SplineSample t =
            spline_.sample(pattern_.centre.x + ux - spline_x_, pattern_.centre.y + uy - spline_y_);
        value_[i] = static_cast<float>(t.value - pivot_);
        if (!slopes) continue;
        slope_x_[i] = static_cast<float>(c * t.slope_x + s * t.slope_y);
        slope_y_[i] = static_cast<float>(-s * t.slope_x + c * t.slope_y);
        slope_theta_[i] = static_cast<float>(-t.slope_x * uy + t.slope_y * ux);
      }
  }
  if (!slopes) return;
  const auto n = static_cast<Eigen::Index>(value_.size());
  jacobian_.resize(n, options_.rotation ? 5 : 4);
  jacobian_.col(0) = -MapConst(slope_x_.data(), n);
  jacobian_.col(1) = -MapConst(slope_y_.data(), n);
  jacobian_.col(2) = MapConst(value_.data(), n);
  jacobian_.col(3).setOnes();
  if (options_.rotation) jacobian_.col(4) = MapConst(slope_theta_.data(), n);
}

/// Weight of the template pixel that lies under pixel (x, y) of the window once the template is turned.
float TemplateRegistration::turned_weight(int x, int y, double c, double s) const {
  const Rect& w = pattern_.window;
  const double rx = x + w.x - pattern_.centre.x;
  const double ry = y + w.y - pattern_.centre.y;
  const int u = static_cast<int>(std::lround(pattern_.centre.x + c * rx - s * ry)) - w.x;
  const int v = static_cast<int>(std::lround(pattern_.centre.y + s * rx + c * ry)) - w.y;
  const bool inside = u >= 0 && v >= 0 && u < w.width && v < w.height;
  return inside ? std::min(pattern_.weights.at(u, v), pattern_.radius > 0 ? 1.0F : pattern_.weights.at(x, y))
                : 0.0F;
}

/// Grey levels under the window moved by whole pixels; weight 0 outside the picture. False where less than
/// half of the mask is covered.
bool TemplateRegistration::take_picture(const Picture& picture, int x, int y, int whole_x, int whole_y,
                                        double theta) {
  const Rect& w = pattern_.window;
  const int left = w.x + whole_x - x;
  const int top = w.y + whole_y - y;
  const bool turned = gaps_ && options_.rotation && theta != 0;
  const double c = std::cos(theta);
  const double s = std::sin(theta);
  double covered = 0;
  for (int j = 0; j < w.height; ++j) {
    const auto line = static_cast<std::size_t>(j) * w.width;
    const bool row_inside = top + j >= 0 && top + j < picture.height();
    const int from = row_inside ? std::clamp(-left, 0, w.width) : w.width;
    const int to = row_inside ? std::clamp(picture.width() - left, from, w.width) : w.width;
    for (int i = 0; i < w.width; ++i) {
      const bool inside = i >= from && i < to;
      level_[line + i] = inside ? picture.at(left + i, top + j) - pivot_ : 0.0F;
      const float weight = turned ? turned_weight(i, j, c, s) : pattern_.weights.at(i, j);
      base_weight_[line + i] = inside ? weight : 0.0F;
      covered += base_weight_[line + i];
    }
  }
  weight_ = base_weight_;
  return covered > 0.5 * pixels_;
}

Eigen::MatrixXd TemplateRegistration::normal_matrix() const {
  const auto n = static_cast<Eigen::Index>(weight_.size());
  const Columns weighted = MapConst(weight_.data(), n).asDiagonal() * jacobian_;
  return (weighted.transpose() * jacobian_).cast<double>();
}

/// The noise of the template adds its own slopes to the derivatives: sum (g + e)^2 = sum g^2 + sum e^2.
Eigen::MatrixXd TemplateRegistration::debiased(const Eigen::MatrixXd& normal, const Pose& fraction) const {
  const auto gain = [&](double f) {
    const double t = (f - std::floor(f)) * kFractions;
    return noise_gain_[static_cast<std::size_t>(std::lround(t))];
  };
  const InterpolationNoise nx = gain(-fraction.dx);
  const InterpolationNoise ny = gain(-fraction.dy);
  double weight = 0;
  for (const float w : weight_) weight += w;
  Eigen::MatrixXd out = normal;
  const double noise = options_.noise_variance * weight;
  out(0, 0) -= std::min(0.7 * normal(0, 0), noise * nx.slope * ny.value);
  out(1, 1) -= std::min(0.7 * normal(1, 1), noise * nx.value * ny.slope);
  return out;
}

/// Noise variance that would explain the present residual, picture and template noisy alike.
double TemplateRegistration::residual_noise(const Pose& at, double gain) const {
  const auto value_gain = [&](double f) {  // continuous, or the iteration could swing between two entries
    const double t = (f - std::floor(f)) * kFractions;
    const auto k = std::min(static_cast<std::size_t>(t), static_cast<std::size_t>(kFractions - 1));
    const double share = t - static_cast<double>(k);
    return (1 - share) * noise_gain_[k].value + share * noise_gain_[k + 1].value;
  };
  double weight = 0;
  double squares = 0;
  for (std::size_t i = 0; i < residual_.size(); ++i) {
    weight += weight_[i];
    squares += static_cast<double>(weight_[i]) * residual_[i] * residual_[i];
  }
  const double parameters = options_.rotation ? 5 : 4;
  return squares / std::max(1.0, weight - parameters) /
         (1 + gain * gain * value_gain(at.dx) * value_gain(at.dy));
}

/// Expectation of sum w J r that is due to the template's noise alone: its slopes (in J, formed at one
/// fraction) and its values (in r, at another) are correlated. A turned template mixes all fractions, which
/// averages it out: 2 J1(z) / z for a disc.
Eigen::Vector2d TemplateRegistration::noise_force(const Pose& formed, const Pose& at, double gain) const {
  // The noise cannot be more than what the residual shows; from clearly less to within its scatter, a ramp.
  const double shown = residual_noise(at, gain);
  const double share = std::clamp((shown / options_.noise_variance - 0.6) / 0.2, 0.0, 1.0);
  const double noise =
      share * options_.noise_variance + (1 - share) * std::min(shown, options_.noise_variance);
  const InterpolationCovariance x = quintic_noise_covariance(-formed.dx, -at.dx);
  const InterpolationCovariance y = quintic_noise_covariance(-formed.dy, -at.dy);
  double weight = 0;
  for (const float w : weight_) weight += w;
  const double z = 2 * std::numbers::pi * pattern_.reach() * std::abs(at.theta);
  const double mixing = z > 1e-3 ? (z < 30 ? 2 * std::cyl_bessel_j(1.0, z) / z : 0) : 1;
  return mixing * gain * noise * weight *
         Eigen::Vector2d(x.slope_value * y.value_value, x.value_value * y.slope_value);
}

double TemplateRegistration::correlation(const std::vector<float>& weights) const {
  double s = 0, sv = 0, sl = 0, svv = 0, sll = 0, svl = 0;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    const double w = weights[i];
    const double v = value_[i];
    const double l = level_[i];
    s += w;
    sv += w * v;
    sl += w * l;
    svv += w * v * v;
    sll += w * l * l;
    svl += w * v * l;
  }
  if (s <= 0) return 0;
  const double spread = (svv - sv * sv / s) * (sll - sl * sl / s);
  return spread > 1e-9 ? (svl - sv * sl / s) / std::sqrt(spread) : 0;
}

/// Sets the weight of pixels to zero whose residual cannot be noise. Returns how many.
std::size_t TemplateRegistration::trim(double gain, double noise_sd) {
  std::vector<float> sizes;
  sizes.reserve(residual_.size());
  for (std::size_t i = 0; i < residual_.size(); ++i)
    if (base_weight_[i] > 0) sizes.push_back(std::abs(residual_[i]));
  if (sizes.empty()) return 0;
  const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
  std::nth_element(sizes.begin(), middle, sizes.end());
  const double limit = std::max({4 * 1.4826 * *middle, 6 * noise_sd, 0.5 * std::abs(gain) * contrast_});
  std::size_t count = 0;
  for (std::size_t i = 0; i < residual_.size(); ++i) {
    weight_[i] = base_weight_[i];
    if (base_weight_[i] > 0 && std::abs(residual_[i]) > limit) {
      weight_[i] = 0;
      ++count;
    }
  }
  if (static_cast<double>(count) > kMaxTrim * static_cast<double>(sizes.size())) {
    weight_ = base_weight_;
    return 0;
  }
  return count;
}

Registration TemplateRegistration::refine(const Picture& picture, int x, int y, const Pose& start) {
  Registration out;
  out.pose = start;
  int whole_x = static_cast<int>(std::lround(start.dx));
  int whole_y = static_cast<int>(std::lround(start.dy));
  Pose fraction{start.dx - whole_x, start.dy - whole_y, start.theta};
  if (!take_picture(picture, x, y, whole_x, whole_y, fraction.theta)) return out;
  sample_template(fraction, true);
  Pose formed = fraction;  // where the derivatives belong to
  Eigen::MatrixXd normal = normal_matrix();
  Eigen::LDLT<Eigen::MatrixXd> factor(normal);
  double gain = 1;
  double offset = 0;
  const auto n = static_cast<Eigen::Index>(value_.size());
  const double noise_sd = std::sqrt(options_.noise_variance);
  bool trimmed = false;
  std::size_t trimmed_count = 0;
  const auto form_residual = [&] {
    const auto a = static_cast<float>(gain);
    const auto b = static_cast<float>(offset);
    for (std::size_t i = 0; i < residual_.size(); ++i) residual_[i] = level_[i] - a * value_[i] - b;
  };
  for (out.iterations = 1; out.iterations <= options_.max_iterations; ++out.iterations) {
    form_residual();
    const Eigen::VectorXf weighted = MapConst(weight_.data(), n).cwiseProduct(MapConst(residual_.data(), n));
    Eigen::VectorXd force = (jacobian_.transpose() * weighted).cast<double>();
    force.head<2>() -= noise_force(formed, fraction, gain);
    const Eigen::VectorXd step = factor.solve(force);
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
    if (std::hypot(whole_x + fraction.dx - start.dx, whole_y + fraction.dy - start.dy) > options_.max_step_px)
      return out;
    const double turn_px = std::abs(turn) * pattern_.reach();
    bool settled = length < options_.tolerance_px && turn_px < 10 * options_.tolerance_px;
    const bool re_centre = std::abs(fraction.dx) > 0.75 || std::abs(fraction.dy) > 0.75;
    if (re_centre) {
      const int sx = static_cast<int>(std::lround(fraction.dx));
      const int sy = static_cast<int>(std::lround(fraction.dy));
      whole_x += sx;
      whole_y += sy;
      fraction.dx -= sx;
      fraction.dy -= sy;
      if (!take_picture(picture, x, y, whole_x, whole_y, fraction.theta)) return out;
      trimmed = false;
    }
    const bool re_form = re_centre || std::hypot(fraction.dx - formed.dx, fraction.dy - formed.dy) > 0.15 ||
                         std::abs(fraction.theta - formed.theta) * pattern_.reach() > 0.5;
    sample_template(fraction, re_form);
    if (settled && !trimmed) {
      form_residual();
      trimmed_count = trim(gain, noise_sd);
      trimmed = true;
      if (trimmed_count > 0) {
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
  out.ncc = correlation(base_weight_);
  if (!out.converged) return out;

  form_residual();
  double weight = 0;
  double squares = 0;
  for (std::size_t i = 0; i < residual_.size(); ++i) {
    weight += weight_[i];
    squares += static_cast<double>(weight_[i]) * residual_[i] * residual_[i];
  }
  const auto parameters = static_cast<double>(jacobian_.cols());
  out.trimmed_share = static_cast<double>(trimmed_count) / pixels_;
  out.residual_rms = std::sqrt(squares / std::max(1.0, weight - parameters));

  // A residual clearly below the estimated noise (a texture passed for noise) is the better estimate; nearly
  // none is the template met again in its own frame.
  const double shown = residual_noise(fraction, gain);
  const bool quieter = shown < 0.8 * options_.noise_variance && shown > 0.1 * options_.noise_variance;
  const double noise = quieter ? std::max(shown, 1.0 / 12) : options_.noise_variance;
  const Eigen::MatrixXd inverse = debiased(normal, fraction).inverse();
  const Eigen::MatrixXd spread = inverse * normal * inverse / (gain * gain);
  out.covariance = noise * spread.topLeftCorner<2, 2>();
  if (options_.rotation) out.sigma_theta = std::sqrt(noise * spread(4, 4));

  // Residual beyond noise: something in the picture that the model does not have.
  const double expected = out.residual_rms * out.residual_rms * std::min(1.0, noise / shown);
  const double excess = out.residual_rms * out.residual_rms - expected;
  // Four times the scatter of a variance estimate, and a tenth for noise that is not quite white.
  const double tolerated = expected * (0.1 + 4 * std::sqrt(2 / std::max(1.0, weight)));
  if (excess <= tolerated) return out;
  out.excess_rms = std::sqrt(excess);
  Eigen::MatrixXd meat = Eigen::MatrixXd::Zero(normal.rows(), normal.cols());
  Eigen::VectorXd score(normal.rows());
  for (int by = 0; by < pattern_.window.height; by += kBlock)
    for (int bx = 0; bx < pattern_.window.width; bx += kBlock) {
      score.setZero();
      for (int j = by; j < std::min(by + kBlock, pattern_.window.height); ++j)
        for (int i = bx; i < std::min(bx + kBlock, pattern_.window.width); ++i) {
          const auto p = static_cast<Eigen::Index>(j) * pattern_.window.width + i;
          const auto k = static_cast<std::size_t>(p);
          if (weight_[k] > 0)
            score += (weight_[k] * residual_[k]) * jacobian_.row(p).transpose().cast<double>();
        }
      meat += score * score.transpose();
    }
  const double share = excess / (excess + expected);
  const Eigen::MatrixXd sandwich = inverse * meat * inverse / (gain * gain);
  out.covariance += share * sandwich.topLeftCorner<2, 2>();
  if (options_.rotation)
    out.sigma_theta = std::sqrt(out.sigma_theta * out.sigma_theta + share * sandwich(4, 4));
  return out;
}

double TemplateRegistration::score(const Picture& picture, int x, int y, const Pose& pose) {
  const int whole_x = static_cast<int>(std::lround(pose.dx));
  const int whole_y = static_cast<int>(std::lround(pose.dy));
  if (!take_picture(picture, x, y, whole_x, whole_y, pose.theta)) return 0;
  sample_template({pose.dx - whole_x, pose.dy - whole_y, pose.theta}, false);
  return correlation(base_weight_);
}

Picture TemplateRegistration::turned(double theta) const {
  const Rect& w = pattern_.window;
  Picture out(w.width, w.height);
  const double c = std::cos(theta);
  const double s = std::sin(theta);
  for (int y = 0; y < w.height; ++y)
    for (int x = 0; x < w.width; ++x) {
      const double rx = x + w.x - pattern_.centre.x;
      const double ry = y + w.y - pattern_.centre.y;
      out.at(x, y) = static_cast<float>(spline_.value(pattern_.centre.x + c * rx - s * ry - spline_x_,
                                                      pattern_.centre.y + s * rx + c * ry - spline_y_));
    }
  return out;
}

}  // namespace tribotrack::vision
