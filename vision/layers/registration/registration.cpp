#include "vision/layers/registration/registration.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstring>

#include "vision/kernels/outlier_pixels.h"

namespace tribotrack::vision {
namespace {

constexpr int kBorder = 1;              ///< px beyond the rim's reach: the ground's own level is learnt there
constexpr double kTurnTolerance = 0.1;  ///< px at the rim: further the disc's picture is turned anew
constexpr double kTolerance = 0.1;      ///< of the standard deviation: a step leaves far less than it is long
constexpr double kReform = 0.15;        ///< px: the derivatives are good for this far
constexpr double kMaxMove = 2;          ///< px from the start
constexpr int kMaxIterations = 12;
constexpr double kMaxTrim = 0.2;
constexpr double kStrangeEdge = 3;  ///< px about what covers the disc that are half covered
constexpr double kLeastRim = 0.6;   ///< share of the rim that must be in the picture over known ground
constexpr std::size_t kRowBytes = kTile * sizeof(float);
constexpr double kOddPlateau = 1.25;  ///< chi^2 per pixel: look at the disc's middle pixel by pixel

}  // namespace

LayeredRegistration::LayeredRegistration(const LayeredDisc& disc, const GroundPicture& ground,
                                         const LayerKernels& layers, const TileKernels& tiles)
    : disc_(disc), ground_(ground), layer_kernels_(layers), tile_kernels_(tiles) {
  reach_ = static_cast<int>(std::ceil(disc.rim().outer())) + kBorder;
  for (int i = -disc.half(); i <= disc.half(); ++i) ramp_.push_back(static_cast<float>(i));
}

void LayeredRegistration::set_noise(const NoiseLaw& noise) {
  noise_ = noise;
  make_plateau();
}

void LayeredRegistration::disc_changed(int frames) {
  frames_ = std::max(1, frames);
  share_ = QuinticSpline(disc_.share());
  cached_theta_ = 1e9;
  turn_to(0);
  choose_pixels(frames);
  make_plateau();
}

void LayeredRegistration::turn_to(double theta) {
  if (std::abs(theta - cached_theta_) * disc_.radius() < kTurnTolerance) return;
  if (!disc_.turning()) {
    if (cached_theta_ == 0) return;
    shown_ = disc_.at(0);
    standing_ = QuinticSpline(shown_);
    cached_theta_ = 0;
    return;
  }
  Picture slope;
  shown_ = disc_.at(theta, &slope);
  standing_ = QuinticSpline(shown_);
  slope_theta_ = QuinticSpline(slope);
  cached_theta_ = theta;
}

/// The rim, and whatever of the disc's picture stands out of its noise; all of it where it turns.
void LayeredRegistration::choose_pixels(int frames) {
  const int size = 2 * disc_.half() + 1;
  Picture value(size, size), x(size, size), y(size, size), wx(size, size), wy(size, size);
  standing_.sample_window(0, 0, size, size, value.levels().data(), x.levels().data(), y.levels().data());
  share_.sample_window(0, 0, size, size, value.levels().data(), wx.levels().data(), wy.levels().data());
  const auto below = static_cast<float>(ground_.mean());
  Picture weights(size, size);
  const double outer = disc_.rim().outer() + kBorder;
  for (int j = 0; j < size; ++j)
    for (int i = 0; i < size; ++i) {
      if (std::hypot(i - disc_.half(), j - disc_.half()) > outer) continue;
      weights.at(i, j) = 1;
      x.at(i, j) += below * wx.at(i, j);
      y.at(i, j) += below * wy.at(i, j);
    }
  Picture mask = weights;
  if (!disc_.turning()) {
    InformativeOptions options;
    const InterpolationNoise gain = quintic_noise(0);
    options.noise_square = 2 * noise_.at(below) / std::max(1, frames) * gain.slope * gain.value;
    mask = informative_pixels(x, y, weights, options);
    // The ground's light is told from beside the rim, too: with light in the picture, the rim's own picture
    // does not hold it where it was.
    if (out_of_picture_)
      for (int j = 0; j < size; ++j)
        for (int i = 0; i < size; ++i)
          if (weights.at(i, j) > 0 && std::hypot(i - disc_.half(), j - disc_.half()) > disc_.rim().outer())
            mask.at(i, j) = 1;
  }
  places_ = cover_with_tiles(mask);
  const std::size_t n = places_.size() * kTilePixels;
  mask_.assign(n, 0);
  for (TileArrays* a : {&arrays_.disc, &arrays_.share, &arrays_.ground}) {
    a->tiles = places_.size();
    for (auto* v : {&a->value, &a->slope_x, &a->slope_y}) v->resize(n);
  }
  arrays_.turn.tiles = places_.size();
  if (disc_.turning()) arrays_.turn.value.resize(n);
  arrays_.tiles = places_.size();
  for (auto* v : {&arrays_.u, &arrays_.v, &arrays_.level, &arrays_.weight, &arrays_.ground_variance,
                  &arrays_.rim, &arrays_.step_x, &arrays_.step_y, &arrays_.blended})
    v->resize(n);
  corners_.resize(places_.size());
  rim_pixels_ = 0;
  for (std::size_t t = 0; t < places_.size(); ++t) {
    TilePlace& place = places_[t];
    place = {place.x - disc_.half(), place.y - disc_.half()};
    for (std::size_t k = 0; k < kTilePixels; ++k) {
      const int i = place.x + static_cast<int>(k % kTile), j = place.y + static_cast<int>(k / kTile);
      const std::size_t at = t * kTilePixels + k;
      const bool on_grid = i <= disc_.half() && j <= disc_.half();
      arrays_.u[at] = static_cast<float>(i);
      arrays_.v[at] = static_cast<float>(j);
      mask_[at] = on_grid ? mask.at(i + disc_.half(), j + disc_.half()) : 0.0F;
      const double rho = std::hypot(i, j);
      const bool rim = mask_[at] > 0 && rho > disc_.rim().inner() && rho < disc_.rim().outer();
      arrays_.rim[at] = rim ? 1.0F : 0.0F;
      rim_pixels_ += rim;
    }
  }
  chosen_ = mask;
  // What is left of the disc itself.
  plateau_weight_ = Picture(size, size);
  runs_.clear();
  for (int j = 0; j < size; ++j)
    for (int i = 0; i < size; ++i) {
      if (mask.at(i, j) > 0 || disc_.share().at(i, j) > 0) continue;
      plateau_weight_.at(i, j) = 1;
      if (runs_.empty() || runs_.back().y != j) runs_.push_back({j, i, 0});
      runs_.back().count = i - runs_.back().first + 1;
    }
}

/// Levels and ground under the tiles. False where too little of the rim lies in the picture over known
/// ground.
bool LayeredRegistration::take_picture(const Picture& picture, int x, int y, const Point& ground) {
  const Rect& region = ground_.region();
  const double gx = x0_ - ground.x - region.x, gy = y0_ - ground.y - region.y;
  const int ix = static_cast<int>(std::floor(gx)), iy = static_cast<int>(std::floor(gy));
  const int near_x = static_cast<int>(std::lround(gx)), near_y = static_cast<int>(std::lround(gy));
  counts_ = mask_;
  const double texture = ground_.texture() * ground_.texture();
  // Less known than the frame's own noise tells, or hardly better than by the ground's mean.
  const auto strange = static_cast<float>(std::max(0.25 * texture, 0.5 * noise_.at(ground_.mean())));
  double seen = 0;
  rim_counted_ = 0;
  for (std::size_t t = 0; t < places_.size(); ++t) {
    const TilePlace& place = places_[t];
    const int left = x0_ + place.x - x, top = y0_ + place.y - y;
    float* level = arrays_.level.data() + t * kTilePixels;
    float* counts = counts_.data() + t * kTilePixels;
    float* unsure = arrays_.ground_variance.data() + t * kTilePixels;
    const float* rim = arrays_.rim.data() + t * kTilePixels;
    const bool inside =
        left >= 0 && top >= 0 && left + kTile <= picture.width() && top + kTile <= picture.height();
    for (int j = 0; j < kTile; ++j)
      if (inside) {
        std::memcpy(level + j * kTile, picture.row(top + j).data() + left, kRowBytes);
      } else {
        for (int i = 0; i < kTile; ++i) {
          const bool in =
              left + i >= 0 && left + i < picture.width() && top + j >= 0 && top + j < picture.height();
          level[j * kTile + i] = in ? picture.at(left + i, top + j) : 0.0F;
          if (!in) counts[j * kTile + i] = 0;
        }
      }
    if (out_of_picture_) leave_unseen(t);
    const int u = near_x + place.x, v = near_y + place.y;
    const bool known = u >= 0 && v >= 0 && u + kTile <= region.width && v + kTile <= region.height;
    if (known) {
      for (int j = 0; j < kTile; ++j)
        std::memcpy(unsure + j * kTile, ground_.variance().row(v + j).data() + u, kRowBytes);
    } else {
      std::fill_n(unsure, kTilePixels, static_cast<float>(ground_.unseen_variance()));
    }
    int on_rim = 0, known_there = 0;
    for (std::size_t k = 0; k < kTilePixels; ++k) {
      const int is = (counts[k] > 0) & (rim[k] > 0);
      on_rim += is;
      known_there += is & (unsure[k] <= strange);
    }
    rim_counted_ += on_rim;
    seen += known_there;
    // Far outside the ground's picture the spline is that of its border.
    const int cx = std::clamp(ix + place.x, -8, region.width),
              cy = std::clamp(iy + place.y, -8, region.height);
    corners_[t] = ground_.spline().coefficient(cx, cy);
  }
  if (seen < kLeastRim * rim_pixels_) return false;
  tile_kernels_.sample(corners_, ground_.spline().stride(), spline_taps(gx - ix, gy - iy), 0, true,
                       arrays_.ground);
  return true;
}

/// L^2 of a pixel of the camera.
float LayeredRegistration::precision(int column, int row) const {
  const Rect& region = out_of_picture_->region();
  const int x = column - region.x, y = row - region.y;
  if (x < 0 || y < 0 || x >= region.width || y >= region.height) return 1;
  const float gain = out_of_picture_->gain().at(x, y);
  return gain * gain;
}

void LayeredRegistration::leave_unseen(std::size_t tile) {
  for (std::size_t k = 0; k < kTilePixels; ++k) {
    const std::size_t i = tile * kTilePixels + k;
    if (counts_[i] > 0 && StaticIllumination::unseen(arrays_.level[i])) counts_[i] = 0;
    if (StaticIllumination::unseen(arrays_.level[i])) arrays_.level[i] = 0;
    if (counts_[i] > 0)
      counts_[i] *= precision(x0_ + static_cast<int>(arrays_.u[i]), y0_ + static_cast<int>(arrays_.v[i]));
  }
}

/// S and w (and the slopes of both) under the tiles for a centre.
void LayeredRegistration::sample(const Point& centre, bool slopes) {
  const double x = disc_.half() + x0_ - centre.x, y = disc_.half() + y0_ - centre.y;
  const int ix = static_cast<int>(std::floor(x)), iy = static_cast<int>(std::floor(y));
  const SplineTaps taps = spline_taps(x - ix, y - iy);
  const auto each = [&](const QuinticSpline& spline, bool with, TileArrays& arrays) {
    for (std::size_t t = 0; t < places_.size(); ++t)
      corners_[t] = spline.coefficient(ix + places_[t].x, iy + places_[t].y);
    tile_kernels_.sample(corners_, spline.stride(), taps, 0, with, arrays);
  };
  each(standing_, slopes, arrays_.disc);
  each(share_, slopes, arrays_.share);
  if (slopes && disc_.turning()) each(slope_theta_, false, arrays_.turn);
}

LayeredRegistration::Matrix LayeredRegistration::normal_matrix(const LayerLight& light,
                                                               const Plateau& plateau, double hold) {
  const LayerNormal sums = layer_kernels_.form(arrays_, counts_, light, noise_);
  const int n = columns();
  Matrix normal(n, n);
  for (int i = 0, k = 0; i < n; ++i)
    for (int j = i; j < n; ++j, ++k) normal(i, j) = normal(j, i) = sums[static_cast<std::size_t>(k)];
  normal.block<3, 3>(kGain, kGain) += plateau.normal;
  normal.block<2, 2>(kStepX, kStepX) += light.gain * light.gain * plateau.steepness;
  normal.block<3, 2>(kGain, kStepX) -= light.gain * plateau.slope;
  normal.block<2, 3>(kStepX, kGain) -= light.gain * plateau.slope.transpose();
  normal(kSlopeX, kSlopeX) += hold;
  normal(kSlopeY, kSlopeY) += hold;
  return normal;
}

float LayeredRegistration::residual(std::size_t i, const LayerLight& light) const {
  const auto shine = static_cast<float>(light.gain + light.slope_x * static_cast<double>(arrays_.u[i]) +
                                        light.slope_y * static_cast<double>(arrays_.v[i]));
  float disc = arrays_.disc.value[i];
  if (disc_.turning()) disc += static_cast<float>(light.turn) * arrays_.turn.value[i];
  return arrays_.level[i] - shine * disc -
         static_cast<float>(light.ground) *
             (arrays_.share.value[i] * arrays_.ground.value[i] + arrays_.blended[i]);
}

/// Pixels that cannot be noise stop counting. Returns how many.
std::size_t LayeredRegistration::trim(const LayerLight& light) {
  std::vector<unsigned char> strange(counts_.size());
  for (std::size_t i = 0; i < counts_.size(); ++i) {
    const float r = residual(i, light);
    strange[i] = arrays_.weight[i] * r * r > static_cast<float>(kTrim * kTrim);
  }
  // While the layers are learnt what is strange may be their own.
  if (std::isfinite(usual_)) spread_outliers(places_, kStrangeEdge, strange);
  std::size_t count = 0;
  for (std::size_t i = 0; i < counts_.size(); ++i) {
    if (strange[i] == 0 || counts_[i] == 0) continue;
    counts_[i] = 0;
    ++count;
  }
  return count;
}

std::optional<LayeredFix> LayeredRegistration::refine(const Picture& picture, int x, int y,
                                                      const LayeredState& start, const LightPrior& prior) {
  x0_ = static_cast<int>(std::lround(start.centre.x));
  y0_ = static_cast<int>(std::lround(start.centre.y));
  turn_to(start.theta);
  if (!take_picture(picture, x, y, start.ground)) return std::nullopt;
  Plateau plateau = take_plateau(picture, x, y);

  // The light is that about the centre's pixel until the end.
  LayeredFix fix;
  fix.state = start;
  LayeredState& s = fix.state;
  LayerLight& light = light_;
  light.slope_x = s.gain * s.slope_x;
  light.slope_y = s.gain * s.slope_y;
  light.gain = s.gain - light.slope_x * (s.centre.x - x0_) - light.slope_y * (s.centre.y - y0_);
  light.ground = s.ground_gain;
  light.turn = s.theta - cached_theta_;
  light.blend = disc_.blend();
  const double hold = prior.sd > 0 ? 1 / (prior.sd * prior.sd) : 0;
  const auto shift = [&] { return Eigen::Vector2d(s.centre.x - x0_, s.centre.y - y0_); };

  sample(s.centre, true);
  Point formed = s.centre;
  Matrix normal = normal_matrix(light, plateau, hold);
  Eigen::LDLT<Matrix> factor(normal);
  LayerForce sums;
  const double tolerance = kTolerance / std::sqrt(std::max(normal(kStepX, kStepX), normal(kStepY, kStepY)));
  bool trimmed = false;
  bool converged = false;
  std::size_t outliers = 0;
  for (int iteration = 0; iteration < kMaxIterations && !converged; ++iteration) {
    sums = layer_kernels_.force(arrays_, light);
    Vector force =
        Eigen::Map<const Eigen::Matrix<double, kLayerColumns, 1>>(sums.force.data()).head(columns());
    force.segment<3>(kGain) += plateau.force_at(light, shift());
    force.segment<2>(kStepX) += plateau.step_force_at(light, shift());
    force(kSlopeX) += hold * (light.gain * prior.slope_x - light.slope_x);
    force(kSlopeY) += hold * (light.gain * prior.slope_y - light.slope_y);
    const Vector step = factor.solve(force);
    if (!step.allFinite()) return std::nullopt;
    const double length = std::hypot(step(kStepX), step(kStepY));
    const double brake = length > 1 ? 1 / length : 1;
    s.centre.x += brake * step(kStepX);
    s.centre.y += brake * step(kStepY);
    light.gain += brake * step(kGain);
    light.slope_x += brake * step(kSlopeX);
    light.slope_y += brake * step(kSlopeY);
    light.ground += brake * step(kGround);
    if (disc_.turning()) light.turn += std::clamp(brake * step(kTurn), -0.2, 0.2);
    if (light.gain < 0.05) return std::nullopt;
    if (std::hypot(s.centre.x - start.centre.x, s.centre.y - start.centre.y) > kMaxMove) return std::nullopt;
    const bool settled = length < tolerance;
    const bool re_form = std::hypot(s.centre.x - formed.x, s.centre.y - formed.y) > kReform;
    if (re_form || !settled) sample(s.centre, re_form);
    if (settled && !trimmed) {
      trimmed = true;
      if (sums.largest > kTrim * kTrim) {
        outliers = trim(light);
        if (static_cast<double>(outliers) > kMaxTrim * sums.correlation.w) return std::nullopt;
      }
      const bool odd = plateau.squares_at(light, shift()) > kOddPlateau * plateau.pixels;
      if (odd) plateau = trimmed_plateau(picture, x, y, light, shift(), kTrim);
      converged = outliers == 0 && !odd;
      if (!converged) {
        if (!re_form) sample(formed = s.centre, true);
        factor.compute(normal = normal_matrix(light, plateau, hold));
      }
    } else if (settled) {
      converged = true;
    } else if (re_form) {
      formed = s.centre;
      factor.compute(normal = normal_matrix(light, plateau, hold));
    }
  }
  if (!converged) return std::nullopt;
  sums = layer_kernels_.force(arrays_, light);
  s.gain = light.gain + light.slope_x * (s.centre.x - x0_) + light.slope_y * (s.centre.y - y0_);
  s.slope_x = light.slope_x / s.gain;
  s.slope_y = light.slope_y / s.gain;
  s.ground_gain = light.ground;
  if (disc_.turning()) s.theta = cached_theta_ + light.turn;

  normal_ = normal;
  const Matrix inverse = normal.inverse();
  fix.covariance = inverse.topLeftCorner<2, 2>();
  fix.sigma_slope = std::sqrt(0.5 * (inverse(kSlopeX, kSlopeX) + inverse(kSlopeY, kSlopeY))) / s.gain;
  const CorrelationSums& c = sums.correlation;
  fix.rim_chi_squared = sums.rim_squares / std::max(1.0, rim_counted_);
  // Four times the scatter of a variance, and a tenth for a noise law that is not quite right.
  const double excess = fix.rim_chi_squared / usual_ - 1;
  if (excess > 0.1 + 4 * std::sqrt(2 / std::max(1.0, rim_counted_)))
    fix.covariance += excess / (1 + excess) * scattered(inverse) / usual_;
  const double variances = (c.vv - c.v * c.v / c.w) * (c.ll - c.l * c.l / c.w);
  fix.ncc = variances > 0 ? (c.vl - c.v * c.l / c.w) / std::sqrt(variances) : 0;
  return fix;
}

}  // namespace tribotrack::vision
