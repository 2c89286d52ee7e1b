#include "vision/registration.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "vision/strangers.h"
#include "vision/visible_rotation.h"

namespace tribotrack::vision {
namespace {

constexpr int kBorder = 12;         ///< context of the spline around the template, px
constexpr int kFractions = 16;      ///< table of interpolation noise
constexpr double kStrangeEdge = 3;  ///< px about what covers the template that are half covered
constexpr double kMaxTrim = 0.4;    ///< more than this share of strange pixels: it is not the template
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

  choose_pixels();
  const bool rotation = options_.rotation;
  options_.rotation = false;
  take_picture(levels_, w.x, w.y, 0, 0, 0);
  sample_template({}, true);
  const Matrix normal = normal_matrix(), honest = debiased(normal, {});
  limit_ = options_.noise_variance * Eigen::MatrixXd(honest).inverse().topLeftCorner<2, 2>();
  template_noise_cost_ =
      (normal - honest).topLeftCorner<2, 2>().trace() / honest.topLeftCorner<2, 2>().trace();
  options_.rotation = rotation;
  if (rotation) arrays_.slope_theta.resize(mask_.size());
}

/// Looks at every pixel of the template once, then keeps those that tell something.
void TemplateRegistration::choose_pixels() {
  const Rect& w = pattern_.window;
  Picture value(w.width, w.height), slope_x(w.width, w.height), slope_y(w.width, w.height);
  spline_.sample_window(w.x - spline_x_, w.y - spline_y_, w.width, w.height, value.levels().data(),
                        slope_x.levels().data(), slope_y.levels().data());
  limit_theta_ = rotation_limit(value, pattern_, options_.noise_variance);
  InformativeOptions options;
  options.noise_square = 2 * template_noise() * noise_gain_[0].slope * noise_gain_[0].value;
  const Picture mask = informative_pixels(slope_x, slope_y, pattern_.weights, options);
  places_ = cover_with_tiles(mask);
  mask_.assign(places_.size() * kTilePixels, 0.0F);
  double chosen = 0;
  for (std::size_t t = 0; t < places_.size(); ++t)
    for (int j = 0; j < kTile; ++j)
      for (int i = 0; i < kTile; ++i) {
        const int x = places_[t].x + i, y = places_[t].y + j;
        if (x >= w.width || y >= w.height) continue;
        mask_[t * kTilePixels + static_cast<std::size_t>(j * kTile + i)] = mask.at(x, y);
        chosen += mask.at(x, y) > 0;
      }
  pixel_share_ = chosen / pixels_;
  pixels_ = chosen;
  arrays_.tiles = places_.size();
  for (auto* v :
       {&arrays_.value, &arrays_.slope_x, &arrays_.slope_y, &arrays_.level, &arrays_.weight, &base_weight_})
    v->resize(mask_.size());
  corners_.resize(places_.size());
}

/// T and, if asked, its derivatives with respect to the pose, at every pixel of the tiles.
void TemplateRegistration::sample_template(const Pose& fraction, bool slopes) {
  if (options_.rotation) return sample_turned(fraction, slopes);
  const double x = pattern_.window.x - spline_x_ - fraction.dx;
  const double y = pattern_.window.y - spline_y_ - fraction.dy;
  const int ix = static_cast<int>(std::floor(x));
  const int iy = static_cast<int>(std::floor(y));
  const SplineTaps taps = spline_taps(x - ix, y - iy);
  for (std::size_t t = 0; t < places_.size(); ++t)
    corners_[t] = spline_.coefficient(ix + places_[t].x, iy + places_[t].y);
  tile_kernels().sample(corners_, spline_.stride(), taps, pivot_, slopes, arrays_);
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

/// Grey levels under the tiles moved by whole pixels; weight 0 outside the picture. False where less than
/// half of the mask is covered.
bool TemplateRegistration::take_picture(const Picture& picture, int x, int y, int whole_x, int whole_y,
                                        double theta) {
  const Rect& w = pattern_.window;
  const bool turned = gaps_ && options_.rotation && theta != 0;
  const double c = std::cos(theta);
  const double s = std::sin(theta);
  base_weight_ = mask_;
  bool all_inside = true;
  for (std::size_t t = 0; t < places_.size(); ++t) {
    const int left = places_[t].x + w.x + whole_x - x;
    const int top = places_[t].y + w.y + whole_y - y;
    float* level = arrays_.level.data() + t * kTilePixels;
    float* weight = base_weight_.data() + t * kTilePixels;
    const bool inside =
        left >= 0 && top >= 0 && left + kTile <= picture.width() && top + kTile <= picture.height();
    all_inside &= inside;
    for (int j = 0; j < kTile; ++j, level += kTile, weight += kTile) {
      if (inside) {
        const float* from = picture.row(top + j).data() + left;
        for (int i = 0; i < kTile; ++i) level[i] = from[i] - pivot_;
      } else {
        for (int i = 0; i < kTile; ++i) {
          const bool seen =
              left + i >= 0 && left + i < picture.width() && top + j >= 0 && top + j < picture.height();
          level[i] = seen ? picture.at(left + i, top + j) - pivot_ : 0.0F;
          if (!seen) weight[i] = 0;
        }
      }
      if (turned)
        for (int i = 0; i < kTile; ++i)
          if (weight[i] > 0) weight[i] = turned_weight(places_[t].x + i, places_[t].y + j, c, s);
    }
  }
  arrays_.weight = base_weight_;
  if (all_inside && !turned) return true;
  double covered = 0;
  for (const float weight : base_weight_) covered += weight;
  return covered > 0.5 * pixels_;
}

TemplateRegistration::Matrix TemplateRegistration::normal_matrix() const {
  const NormalSums sums = tile_kernels().normal(arrays_);
  const int n = columns();
  Matrix normal(n, n);
  for (int i = 0, k = 0; i < n; ++i)
    for (int j = i; j < n; ++j, ++k) normal(i, j) = normal(j, i) = sums[static_cast<std::size_t>(k)];
  return normal;
}

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

double TemplateRegistration::correlation() const {
  const CorrelationSums c = tile_kernels().correlation(arrays_, base_weight_);
  if (c.w <= 0) return 0;
  const double spread = (c.vv - c.v * c.v / c.w) * (c.ll - c.l * c.l / c.w);
  return spread > 1e-9 ? (c.vl - c.v * c.l / c.w) / std::sqrt(spread) : 0;
}

/// Sets the weight of pixels to zero whose residual cannot be noise. Returns how many.
std::size_t TemplateRegistration::trim(const ForceSums& sums, double gain, double offset, double noise_sd) {
  const double least = std::max(6 * noise_sd, 0.5 * std::abs(gain) * contrast_);
  if (sums.largest <= least) return 0;
  std::vector<float> residual(mask_.size());
  const auto a = static_cast<float>(gain), b = static_cast<float>(offset);
  for (std::size_t i = 0; i < mask_.size(); ++i)
    residual[i] = std::abs(arrays_.level[i] - a * arrays_.value[i] - b);
  // The usual residual matters where it is no small one: else it need not be known.
  constexpr double kUsual = 4 * 1.4826;
  std::size_t counted = 0, small = 0;
  for (std::size_t i = 0; i < mask_.size(); ++i) {
    const bool counts = base_weight_[i] > 0;
    counted += counts;
    small += counts & (kUsual * static_cast<double>(residual[i]) <= least);
  }
  double limit = least;
  if (small <= counted / 2) {
    std::vector<float> sizes;
    for (std::size_t i = 0; i < mask_.size(); ++i)
      if (base_weight_[i] > 0) sizes.push_back(residual[i]);
    const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
    std::nth_element(sizes.begin(), middle, sizes.end());
    limit = std::max(least, kUsual * static_cast<double>(*middle));
  }
  std::vector<unsigned char> strange(mask_.size());
  for (std::size_t i = 0; i < mask_.size(); ++i)
    strange[i] = base_weight_[i] > 0 && static_cast<double>(residual[i]) > limit;
  // A texture that has turned is strange wherever it is, until its angle is found.
  if (!options_.rotation) spread_strangers(places_, kStrangeEdge, strange);
  std::size_t count = 0;
  for (std::size_t i = 0; i < mask_.size(); ++i) {
    arrays_.weight[i] = strange[i] != 0 ? 0 : base_weight_[i];
    count += strange[i] != 0 && base_weight_[i] > 0;
  }
  if (static_cast<double>(count) > kMaxTrim * static_cast<double>(counted)) {
    arrays_.weight = base_weight_;
    return 0;
  }
  return count;
}

/// Sandwich covariance of (dx, dy, theta) with the tiles as clusters.
Eigen::Matrix3d TemplateRegistration::sandwich(const Matrix& inverse, double gain, double offset) const {
  Matrix meat = Matrix::Zero(columns(), columns());
  const auto a = static_cast<float>(gain), b = static_cast<float>(offset);
  for (std::size_t t = 0; t < places_.size(); ++t) {
    // A column of the tile at a time beside the others: the compiler takes several at once.
    float x[kTile] = {}, y[kTile] = {}, v[kTile] = {}, one[kTile] = {}, turn[kTile] = {};
    for (std::size_t j = t * kTilePixels; j < (t + 1) * kTilePixels; j += kTile) {
      float weighted[kTile];
      for (std::size_t k = 0; k < kTile; ++k)
        weighted[k] = arrays_.weight[j + k] * (arrays_.level[j + k] - a * arrays_.value[j + k] - b);
      for (std::size_t k = 0; k < kTile; ++k) {
        x[k] -= weighted[k] * arrays_.slope_x[j + k];
        y[k] -= weighted[k] * arrays_.slope_y[j + k];
        v[k] += weighted[k] * arrays_.value[j + k];
        one[k] += weighted[k];
      }
      if (options_.rotation)
        for (std::size_t k = 0; k < kTile; ++k) turn[k] += weighted[k] * arrays_.slope_theta[j + k];
    }
    const auto total = [](const float(&from)[kTile]) {
      double sum = 0;
      for (const float f : from) sum += static_cast<double>(f);
      return sum;
    };
    Vector score(columns());
    score.head<4>() << total(x), total(y), total(v), total(one);
    if (options_.rotation) score(4) = total(turn);
    meat.noalias() += score * score.transpose();
  }
  const Matrix covariance = inverse * meat * inverse / (gain * gain);
  Eigen::Matrix3d out = Eigen::Matrix3d::Zero();
  out.topLeftCorner<2, 2>() = covariance.topLeftCorner<2, 2>();
  if (options_.rotation) out(2, 2) = covariance(4, 4);
  return out;
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
  Matrix normal = normal_matrix();
  Eigen::LDLT<Matrix> factor(normal);
  double gain = 1;
  double offset = 0;
  const double noise_sd = std::sqrt(options_.noise_variance);
  bool trimmed = false;
  std::size_t trimmed_count = 0;
  std::optional<ForceSums> last;  // where they are those of the pose found
  const auto sums_now = [&] {
    return tile_kernels().force(arrays_, static_cast<float>(gain), static_cast<float>(offset));
  };
  for (out.iterations = 1; out.iterations <= options_.max_iterations; ++out.iterations) {
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
    if (re_form || !settled) sample_template(fraction, re_form);
    if (settled && !trimmed) {
      last = sums_now();
      trimmed_count = trim(*last, gain, offset, noise_sd);
      trimmed = true;
      if (trimmed_count > 0) {
        factor.compute(normal = normal_matrix());
        settled = false;
        last.reset();
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
  out.ncc = correlation();
  if (!out.converged) return out;

  const ForceSums sums = last ? *last : sums_now();
  out.trimmed_share = static_cast<double>(trimmed_count) / pixels_;
  out.residual_rms = std::sqrt(sums.squares / std::max(1.0, sums.weight - columns()));

  // A residual clearly below the estimated noise (a texture passed for noise) is the better estimate; nearly
  // none is the template met again in its own frame.
  const double shown = residual_noise(sums, fraction, gain);
  const bool quieter = shown < 0.8 * options_.noise_variance && shown > 0.1 * options_.noise_variance;
  const double noise = quieter ? std::max(shown, 1.0 / 12) : options_.noise_variance;
  const Matrix inverse = debiased(normal, fraction).inverse();
  const Matrix spread = inverse * normal * inverse / (gain * gain);
  out.covariance = noise * spread.topLeftCorner<2, 2>();
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
  if (!take_picture(picture, x, y, whole_x, whole_y, pose.theta)) return 0;
  sample_template({pose.dx - whole_x, pose.dy - whole_y, pose.theta}, false);
  return correlation();
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
