#include "vision/layered_registration.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "vision/strangers.h"

namespace tribotrack::vision {
namespace {

constexpr int kBorder = 1;              ///< px beyond the rim's reach: the ground's own level is learnt there
constexpr double kTurnTolerance = 0.1;  ///< px at the rim: further the disc's picture is turned anew
constexpr double kTolerance = 0.02;     ///< of the standard deviation
constexpr double kReform = 0.15;        ///< px: the derivatives are good for this far
constexpr double kMaxMove = 2;          ///< px from the start
constexpr int kMaxIterations = 12;
constexpr double kTrim = 5;  ///< sd: a pixel further off is something else (dust, glare, a lamp)
constexpr double kMaxTrim = 0.2;
constexpr double kStrangeEdge = 3;    ///< px about what covers the disc that are half covered
constexpr double kLeastRim = 0.6;     ///< share of the rim that must be in the picture over known ground
constexpr double kSureGround = 0.1;   ///< variance of the ground that does not spoil the noise law
constexpr double kLeastLean = 1e-4;   ///< of a rim pixel's share in the information: not worth a sum
constexpr double kSloping = 2;        ///< times the slope that noise alone makes
constexpr double kOddPlateau = 1.25;  ///< chi^2 per pixel: look at the disc's middle pixel by pixel

}  // namespace

/// With r = I - S(u) summed, the residual is r - q . column + gain grad S . shift.
Eigen::Vector3d LayeredRegistration::Plateau::force_at(const LayerLight& light,
                                                       const Eigen::Vector2d& shift) const {
  return force - normal * Eigen::Vector3d(light.gain - 1, light.slope_x, light.slope_y) +
         light.gain * (slope * shift);
}

/// The model's derivative by the centre is -gain grad S.
Eigen::Vector2d LayeredRegistration::Plateau::step_force_at(const LayerLight& light,
                                                            const Eigen::Vector2d& shift) const {
  const Eigen::Vector3d q(light.gain - 1, light.slope_x, light.slope_y);
  return -light.gain * (pull - slope.transpose() * q + light.gain * (steepness * shift));
}

double LayeredRegistration::Plateau::squares_at(const LayerLight& light, const Eigen::Vector2d& shift) const {
  const Eigen::Vector3d q(light.gain - 1, light.slope_x, light.slope_y);
  const Eigen::Vector2d moved = light.gain * shift;
  return squares - 2 * q.dot(force) + q.dot(normal * q) + 2 * moved.dot(pull - slope.transpose() * q) +
         moved.dot(steepness * moved);
}

void LayeredRegistration::Plateau::add(double weight, const Eigen::Vector3d& column,
                                       const Eigen::Vector2d& gradient) {
  normal += weight * column * column.transpose();
  slope += weight * column * gradient.transpose();
  steepness += weight * gradient * gradient.transpose();
  ++pixels;
}

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
  double all = 0;
  for (int j = 0; j < size; ++j)
    for (int i = 0; i < size; ++i) {
      if (std::hypot(i - disc_.half(), j - disc_.half()) > outer) continue;
      weights.at(i, j) = 1;
      ++all;
      x.at(i, j) += below * wx.at(i, j);
      y.at(i, j) += below * wy.at(i, j);
    }
  Picture mask = weights;
  if (!disc_.turning()) {
    InformativeOptions options;
    const InterpolationNoise gain = quintic_noise(0);
    options.noise_square = 2 * noise_.at(below) / std::max(1, frames) * gain.slope * gain.value;
    mask = informative_pixels(x, y, weights, options);
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
  double chosen = 0;
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
      chosen += mask_[at] > 0;
    }
  }
  pixel_share_ = chosen / all;
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

/// grad S at whole pixels, where the middle slopes by more than the noise it was learnt with.
void LayeredRegistration::slope_of_middle() {
  const int size = plateau_weight_.width();
  slope_x_ = slope_y_ = Picture(size, size);
  double squares = 0, noise = 0;
  for (const Run& run : runs_)
    for (int i = run.first; i < run.first + run.count; ++i) {
      if (plateau_weight_.at(i, run.y) == 0) continue;
      const int left = std::max(i - 1, 0), right = std::min(i + 1, size - 1);
      const int above = std::max(run.y - 1, 0), below = std::min(run.y + 1, size - 1);
      const float x = 0.5F * (shown_.at(right, run.y) - shown_.at(left, run.y));
      const float y = 0.5F * (shown_.at(i, below) - shown_.at(i, above));
      slope_x_.at(i, run.y) = x;
      slope_y_.at(i, run.y) = y;
      squares += static_cast<double>(x * x + y * y);
      noise += noise_.at(shown_.at(i, run.y)) / frames_;
    }
  if (squares <= kSloping * noise) slope_x_ = slope_y_ = Picture();
}

Eigen::Vector2d LayeredRegistration::shown_slope(int i, int j) const {
  if (slope_x_.empty()) return Eigen::Vector2d::Zero();
  return {static_cast<double>(slope_x_.at(i, j)), static_cast<double>(slope_y_.at(i, j))};
}

void LayeredRegistration::make_plateau() {
  if (shown_.empty()) return;
  plateau_ = {};
  slope_of_middle();
  for (const Run& run : runs_)
    for (int i = run.first; i < run.first + run.count; ++i) {
      float& weight = plateau_weight_.at(i, run.y);
      if (weight == 0) continue;
      const double level = shown_.at(i, run.y);
      weight = static_cast<float>(1 / noise_.at(level));
      const Eigen::Vector3d column = level * Eigen::Vector3d(1, i - disc_.half(), run.y - disc_.half());
      plateau_.add(static_cast<double>(weight), column, shown_slope(i, run.y));
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
        std::copy_n(picture.row(top + j).data() + left, kTile, level + j * kTile);
      } else {
        for (int i = 0; i < kTile; ++i) {
          const bool in =
              left + i >= 0 && left + i < picture.width() && top + j >= 0 && top + j < picture.height();
          level[j * kTile + i] = in ? picture.at(left + i, top + j) : 0.0F;
          if (!in) counts[j * kTile + i] = 0;
        }
      }
    const int u = near_x + place.x, v = near_y + place.y;
    const bool known = u >= 0 && v >= 0 && u + kTile <= region.width && v + kTile <= region.height;
    if (known) {
      for (int j = 0; j < kTile; ++j)
        std::copy_n(ground_.variance().row(v + j).data() + u, kTile, unsure + j * kTile);
    } else {
      std::fill_n(unsure, kTilePixels, static_cast<float>(ground_.unseen_variance()));
    }
    for (std::size_t k = 0; k < kTilePixels; ++k)
      if (counts[k] > 0 && rim[k] > 0) {
        ++rim_counted_;
        seen += unsure[k] <= strange;
      }
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

LayeredRegistration::Plateau LayeredRegistration::take_plateau(const Picture& picture, int x, int y) const {
  Plateau out = plateau_;
  const int left = x0_ - disc_.half() - x, top = y0_ - disc_.half() - y;
  for (const Run& run : runs_) {
    const int px = left + run.first, py = top + run.y;
    if (px < 0 || py < 0 || px + run.count > picture.width() || py >= picture.height())
      return trimmed_plateau(picture, x, y, {}, Eigen::Vector2d::Zero());
    const auto first = static_cast<std::size_t>(run.first);
    const PlateauSums sums =
        layer_kernels_.plateau({picture.row(py).data() + px, shown_.row(run.y).data() + first,
                                plateau_weight_.row(run.y).data() + first, ramp_.data() + first, run.count});
    out.force += Eigen::Vector3d(sums[0], sums[1], (run.y - disc_.half()) * sums[0]);
    out.squares += sums[2];
    if (slope_x_.empty()) continue;
    const auto row = [&](const float* from) { return Eigen::Map<const Eigen::ArrayXf>(from, run.count); };
    const Eigen::ArrayXf pull = row(plateau_weight_.row(run.y).data() + first) *
                                (row(picture.row(py).data() + px) - row(shown_.row(run.y).data() + first));
    out.pull += Eigen::Vector2f((pull * row(slope_x_.row(run.y).data() + first)).sum(),
                                (pull * row(slope_y_.row(run.y).data() + first)).sum())
                    .cast<double>();
  }
  return out;
}

/// The same pixel by pixel: without what lies outside the picture and what cannot be noise.
LayeredRegistration::Plateau LayeredRegistration::trimmed_plateau(const Picture& picture, int x, int y,
                                                                  const LayerLight& light,
                                                                  const Eigen::Vector2d& shift) const {
  Plateau out;
  const int left = x0_ - disc_.half() - x, top = y0_ - disc_.half() - y;
  for (const Run& run : runs_)
    for (int i = run.first; i < run.first + run.count; ++i) {
      const int px = left + i, py = top + run.y;
      const double weight = plateau_weight_.at(i, run.y);
      if (weight == 0 || px < 0 || py < 0 || px >= picture.width() || py >= picture.height()) continue;
      const double u = i - disc_.half(), v = run.y - disc_.half();
      const double level = shown_.at(i, run.y);
      const Eigen::Vector2d gradient = shown_slope(i, run.y);
      const double off = picture.at(px, py) -
                         (light.gain + light.slope_x * u + light.slope_y * v) * (level - gradient.dot(shift));
      if (weight * off * off > kTrim * kTrim) continue;
      const double r = picture.at(px, py) - level;
      const Eigen::Vector3d column = level * Eigen::Vector3d(1, u, v);
      out.add(weight, column, gradient);
      out.force += weight * r * column;
      out.pull += weight * r * gradient;
      out.squares += weight * r * r;
    }
  return out;
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
  if (std::isfinite(usual_)) spread_strangers(places_, kStrangeEdge, strange);
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
  std::size_t strangers = 0;
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
        strangers = trim(light);
        if (static_cast<double>(strangers) > kMaxTrim * sums.correlation.w) return std::nullopt;
      }
      const bool odd = plateau.squares_at(light, shift()) > kOddPlateau * plateau.pixels;
      if (odd) plateau = trimmed_plateau(picture, x, y, light, shift());
      converged = strangers == 0 && !odd;
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
  fix.trimmed_share = static_cast<double>(strangers) / std::max(1.0, c.w + static_cast<double>(strangers));
  fix.chi_squared =
      (sums.squares + plateau.squares_at(light, shift())) / std::max(1.0, c.w + plateau.pixels - columns());
  fix.rim_chi_squared = sums.rim_squares / std::max(1.0, rim_counted_);
  // Four times the scatter of a variance, and a tenth for a noise law that is not quite right.
  const double excess = fix.rim_chi_squared / usual_ - 1;
  if (excess > 0.1 + 4 * std::sqrt(2 / std::max(1.0, rim_counted_)))
    fix.covariance += excess / (1 + excess) * scattered(inverse) / usual_;
  const double variances = (c.vv - c.v * c.v / c.w) * (c.ll - c.l * c.l / c.w);
  fix.ncc = variances > 0 ? (c.vl - c.v * c.l / c.w) / std::sqrt(variances) : 0;
  return fix;
}

void LayeredRegistration::add_rim(RimSums& sums) const {
  const auto under = static_cast<float>(light_.ground), mean = static_cast<float>(ground_.mean());
  Eigen::Matrix<double, Eigen::Dynamic, 2, Eigen::ColMajor, kLayerColumns, 2> mixed =
      Eigen::Matrix<double, Eigen::Dynamic, 2>::Zero(columns(), 2);
  for (std::size_t i = 0; i < mask_.size(); ++i) {
    if (!(counts_[i] * arrays_.rim[i] > 0)) continue;
    const float wx = arrays_.share.slope_x[i], wy = arrays_.share.slope_y[i];
    const float q = under * (wx * arrays_.ground.slope_x[i] + wy * arrays_.ground.slope_y[i]);
    const float r = residual(i, light_), weight = arrays_.weight[i];
    sums.qr += static_cast<double>(weight * q * r);
    sums.qq += static_cast<double>(weight * q * q);
    const float off = -under * (arrays_.ground.value[i] - mean);
    const Eigen::Vector2d shift(static_cast<double>(off * wx), static_cast<double>(off * wy));
    sums.shift_normal += static_cast<double>(weight) * shift * shift.transpose();
    sums.shift_force += static_cast<double>(weight * r) * shift;
    const float s = arrays_.disc.value[i];
    const float column[] = {arrays_.step_x[i],
                            arrays_.step_y[i],
                            s,
                            s * arrays_.u[i],
                            s * arrays_.v[i],
                            arrays_.share.value[i] * arrays_.ground.value[i] + arrays_.blended[i],
                            0.0F};
    for (Eigen::Index c = 0; c < mixed.rows(); ++c)
      mixed.row(c) += static_cast<double>(weight * column[c]) * shift.transpose();
  }
  sums.shift_normal -= mixed.transpose() * Eigen::LDLT<Matrix>(normal_).solve(Eigen::MatrixXd(mixed));
}

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

/// Pixels of the tiles on either side of the rim.
void LayeredRegistration::add_residuals(LevelSums& sums) const {
  const double inner = disc_.rim().inner(), outer = disc_.rim().outer();
  for (std::size_t i = 0; i < mask_.size(); ++i) {
    if (!(arrays_.level[i] > 0) || (mask_[i] > 0 && counts_[i] == 0)) continue;
    const double u = arrays_.u[i], v = arrays_.v[i], rho_squared = u * u + v * v;
    const bool outside = rho_squared >= outer * outer;
    if (rho_squared > inner * inner && !outside) continue;
    if (outside && static_cast<double>(arrays_.ground_variance[i]) > kSureGround * noise_.constant) continue;
    const double r = residual(i, light_);
    const double level = arrays_.level[i] - r;
    const double square = r * r;
    if (square > kTrim * kTrim * noise_.at(level)) continue;
    sums.n += 1;
    sums.level += level;
    sums.level_level += level * level;
    sums.square += square;
    sums.level_square += level * square;
  }
}

}  // namespace tribotrack::vision
