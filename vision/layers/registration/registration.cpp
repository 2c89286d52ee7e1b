#include "vision/layers/registration/registration.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "vision/kernels/dense.h"
#include "vision/kernels/median.h"
#include "vision/kernels/tile_kernels.h"

namespace tribotrack::vision {
namespace {

constexpr double kTolerance = 0.1;  ///< of the standard deviation: a step leaves far less than it is long
constexpr double kReform = 0.15;    ///< px: the derivatives are good for this far
constexpr double kMaxMove = 2;      ///< px from the start
constexpr int kMaxIterations = 12;
constexpr double kTrim = 5;         ///< sd: a pixel further off is something else (dust, a hand, a lamp)
constexpr double kMaxTrim = 0.2;    ///< share of the pixels
constexpr double kLeastSeen = 0.6;  ///< share of the informative pixels that must be in the picture
constexpr double kMostTaken = 0.7;  ///< of few clusters' squares: what is left would scatter too much
constexpr double kGroundGain =
    0.3;                         ///< sd of the ground's light before a frame is looked at: it hardly binds
constexpr double kFixed = 1e12;  ///< information that holds a quantity where it is

double hold(double sd) {
  return sd > 0 ? 1 / (sd * sd) : kFixed;
}

}  // namespace

void LayeredRegistration::set_part(const PartPictures& part, double frames) {
  half_ = part.half;
  light_.blend = part.blend;
  light_.mean = ground_.mean();
  level_ = QuinticSpline(part.level);
  share_ = QuinticSpline(part.share);
  variance_ = part.variance;
  choose_pixels(part, frames);
}

/// What stands out of the noise of the picture learnt: the rim, the edge of a shadow, marks on the part.
void LayeredRegistration::choose_pixels(const PartPictures& part, double frames) {
  const int size = 2 * half_ + 1;
  Picture value(size, size), x(size, size), y(size, size), inside(size, size);
  level_.sample_window(0, 0, size, size, value.levels().data(), x.levels().data(), y.levels().data());
  for (int j = 0; j < size; ++j)
    for (int i = 0; i < size; ++i) {
      const float sd = std::sqrt(part.variance.at(i, j));
      x.at(i, j) /= sd;
      y.at(i, j) /= sd;
      inside.at(i, j) = std::hypot(i - half_, j - half_) <= half_ - 1 ? 1.0F : 0.0F;
    }
  const InterpolationNoise noise = quintic_noise(0);
  const Picture chosen = informative_pixels(x, y, inside, 2 * noise.slope * noise.value / frames);
  places_ = cover_with_tiles(chosen);
  mask_ = under_tiles(chosen, places_);
  arrays_.resize(places_.size());
  corners_.resize(places_.size());
  pixels_ = 0;
  std::vector<Eigen::Matrix2d> information;
  for (std::size_t t = 0; t < places_.size(); ++t) {
    TilePlace& place = places_[t];
    place = {place.x - half_, place.y - half_};
    Eigen::Matrix2d here = Eigen::Matrix2d::Zero();
    for (std::size_t k = 0; k < kTilePixels; ++k) {
      const int i = place.x + static_cast<int>(k % kTile), j = place.y + static_cast<int>(k / kTile);
      const std::size_t at = t * kTilePixels + k;
      arrays_.u[at] = static_cast<float>(i);
      arrays_.v[at] = static_cast<float>(j);
      pixels_ += static_cast<double>(mask_[at]);
      if (!(mask_[at] > 0)) continue;
      const Eigen::Vector2d slope(x.at(i + half_, j + half_), y.at(i + half_, j + half_));
      here += slope * slope.transpose();
    }
    information.push_back(here);
  }
  make_clusters(information);
}

void LayeredRegistration::make_clusters(const std::vector<Eigen::Matrix2d>& information) {
  // Sectors of a tile's arc where the information lies, so that a cluster is one tile wide.
  double weight = 0, distance = 0;
  const auto middle = [&](std::size_t t) {
    return Point{places_[t].x + 0.5 * (kTile - 1), places_[t].y + 0.5 * (kTile - 1)};
  };
  Eigen::Matrix2d all = Eigen::Matrix2d::Zero();
  for (std::size_t t = 0; t < places_.size(); ++t) {
    weight += information[t].trace();
    distance += information[t].trace() * std::hypot(middle(t).x, middle(t).y);
    all += information[t];
  }
  clusters_ = static_cast<std::size_t>(std::max(3.0, std::numbers::pi * distance / weight / kTile));
  std::vector<Eigen::Matrix2d> in(clusters_, Eigen::Matrix2d::Zero());
  cluster_.clear();
  for (std::size_t t = 0; t < places_.size(); ++t) {
    const double turn = std::atan2(middle(t).y, middle(t).x) / std::numbers::pi + 1;  // 0 .. 2
    cluster_.push_back(static_cast<std::size_t>((turn - std::floor(turn)) * static_cast<double>(clusters_)) %
                       clusters_);
    in[cluster_.back()] += information[t];
  }
  share_taken_.setZero();
  const Eigen::Matrix2d inverse = all.inverse();
  for (const Eigen::Matrix2d& n : in) {
    const Eigen::Matrix2d leverage = inverse * n;
    share_taken_ += (leverage * leverage).diagonal().array();
  }
  share_taken_ = share_taken_.min(kMostTaken);
}

/// Levels and ground under the tiles. False where too little of the part lies in the picture.
bool LayeredRegistration::take_picture(const Picture& picture, int x, int y, const Point& ground) {
  const Rect& region = ground_.region();
  const double gx = x0_ - ground.x - region.x, gy = y0_ - ground.y - region.y;
  const int ix = static_cast<int>(std::floor(gx)), iy = static_cast<int>(std::floor(gy));
  const int near_x = static_cast<int>(std::lround(gx)), near_y = static_cast<int>(std::lround(gy));
  counts_ = mask_;
  take_levels(picture, x0_ - x, y0_ - y, places_, 0, arrays_.level, counts_);
  double seen = 0;
  for (std::size_t t = 0; t < places_.size(); ++t) {
    const TilePlace& place = places_[t];
    const float* counts = counts_.data() + t * kTilePixels;
    float* unsure = arrays_.ground_variance.data() + t * kTilePixels;
    for (int j = 0; j < kTile; ++j) {
      const auto row = ground_.variance().row(std::clamp(near_y + place.y + j, 0, region.height - 1));
      for (int i = 0; i < kTile; ++i)
        unsure[j * kTile + i] =
            row[static_cast<std::size_t>(std::clamp(near_x + place.x + i, 0, region.width - 1))];
    }
    for (std::size_t k = 0; k < kTilePixels; ++k) seen += static_cast<double>(counts[k]);
    // Far outside the ground's picture the spline is that of its border.
    corners_[t] = ground_.spline().coefficient(std::clamp(ix + place.x, -8, region.width),
                                               std::clamp(iy + place.y, -8, region.height));
  }
  if (seen < kLeastSeen * pixels_) return false;
  sample_tiles(corners_, ground_.spline().stride(), spline_taps(gx - ix, gy - iy), 0, true, arrays_.ground);
  return true;
}

/// V under the tiles for a centre, between its places linearly.
void LayeredRegistration::take_variance(const Point& centre) {
  const double x = half_ + x0_ - centre.x, y = half_ + y0_ - centre.y;
  const int ix = static_cast<int>(std::floor(x)), iy = static_cast<int>(std::floor(y));
  const auto fx = static_cast<float>(x - ix), fy = static_cast<float>(y - iy);
  for (std::size_t t = 0; t < places_.size(); ++t)
    for (int j = 0; j < kTile; ++j) {
      const int top = std::clamp(iy + places_[t].y + j, 0, 2 * half_ - 1);
      const float *upper = variance_.row(top).data(), *lower = variance_.row(top + 1).data();
      for (int i = 0; i < kTile; ++i) {
        const int left = std::clamp(ix + places_[t].x + i, 0, 2 * half_ - 1);
        arrays_.variance[t * kTilePixels + static_cast<std::size_t>(j * kTile + i)] =
            (1 - fy) * ((1 - fx) * upper[left] + fx * upper[left + 1]) +
            fy * ((1 - fx) * lower[left] + fx * lower[left + 1]);
      }
    }
}

/// F and alpha (and the slopes of both) under the tiles for a centre.
void LayeredRegistration::sample(const Point& centre, bool slopes) {
  const double x = half_ + x0_ - centre.x, y = half_ + y0_ - centre.y;
  level_.sample_tiles(x, y, places_, corners_, 0, slopes, arrays_.part);
  share_.sample_tiles(x, y, places_, corners_, 0, slopes, arrays_.share);
}

LayeredRegistration::Matrix LayeredRegistration::normal_matrix(const LightPrior& prior) {
  Matrix normal = symmetric(form_normal(arrays_, counts_, light_), kLayerColumns);
  normal(kSlopeX, kSlopeX) += hold(prior.sd);
  normal(kSlopeY, kSlopeY) += hold(prior.sd);
  normal(kGround, kGround) += hold(kGroundGain);
  return normal;
}

float LayeredRegistration::residual(std::size_t i) const {
  const float part = arrays_.part.value[i];
  const auto shine = static_cast<float>(light_.gain + light_.slope_x * static_cast<double>(arrays_.u[i]) +
                                        light_.slope_y * static_cast<double>(arrays_.v[i]));
  return arrays_.level[i] - shine * (part - static_cast<float>(light_.mean) * arrays_.share.value[i]) -
         static_cast<float>(light_.ground) * arrays_.below[i];
}

/// Pixels that cannot be noise stop counting: far off by what this frame's residuals are in most places,
/// which in a coded frame of fast motion is more than usual. Returns how many.
std::size_t LayeredRegistration::trim() {
  std::vector<float> squares;
  for (std::size_t i = 0; i < counts_.size(); ++i)
    if (const float r = residual(i); counts_[i] > 0) squares.push_back(arrays_.weight[i] * r * r);
  const float usual = std::max(1.0F, static_cast<float>(kNormalMad * kNormalMad) * median(squares));
  std::vector<unsigned char> strange(counts_.size());
  for (std::size_t i = 0; i < counts_.size(); ++i) {
    const float r = residual(i);
    strange[i] = arrays_.weight[i] * r * r > static_cast<float>(kTrim * kTrim) * usual;
  }
  return leave_out(places_, std::move(strange), true, counts_);
}

std::optional<LayeredFix> LayeredRegistration::refine(const Picture& picture, int x, int y,
                                                      const LayeredState& start, const LightPrior& prior) {
  x0_ = static_cast<int>(std::lround(start.centre.x));
  y0_ = static_cast<int>(std::lround(start.centre.y));
  if (!take_picture(picture, x, y, start.ground)) return std::nullopt;
  take_variance(start.centre);

  // The light is that about the centre's pixel until the end.
  LayeredFix fix;
  fix.state = start;
  LayeredState& s = fix.state;
  light_.slope_x = s.gain * prior.slope_x;
  light_.slope_y = s.gain * prior.slope_y;
  light_.gain = s.gain - light_.slope_x * (s.centre.x - x0_) - light_.slope_y * (s.centre.y - y0_);
  light_.ground = s.ground_gain;

  sample(s.centre, true);
  Point formed = s.centre;
  normal_ = normal_matrix(prior);
  FewFactor factor(normal_);
  const double tolerance = kTolerance / std::sqrt(std::max(normal_(kStepX, kStepX), normal_(kStepY, kStepY)));
  bool trimmed = false;
  bool converged = false;
  LayerForce sums;
  for (int iteration = 0; iteration < kMaxIterations && !converged; ++iteration) {
    sums = layer_force(arrays_, light_, 0, arrays_.tiles);
    Vector force = Eigen::Map<const Eigen::Matrix<double, kLayerColumns, 1>>(sums.force.data());
    force(kSlopeX) += hold(prior.sd) * (light_.gain * prior.slope_x - light_.slope_x);
    force(kSlopeY) += hold(prior.sd) * (light_.gain * prior.slope_y - light_.slope_y);
    force(kGround) += hold(kGroundGain) * (1 - light_.ground);
    const Vector step = factor.solve(force);
    if (!step.allFinite()) return std::nullopt;
    const double length = std::hypot(step(kStepX), step(kStepY));
    const double brake = length > 1 ? 1 / length : 1;
    s.centre.x += brake * step(kStepX);
    s.centre.y += brake * step(kStepY);
    light_.gain += brake * step(kGain);
    light_.slope_x += brake * step(kSlopeX);
    light_.slope_y += brake * step(kSlopeY);
    light_.ground += brake * step(kGround);
    if (light_.gain < 0.05) return std::nullopt;
    if (std::hypot(s.centre.x - start.centre.x, s.centre.y - start.centre.y) > kMaxMove) return std::nullopt;
    const bool settled = length < tolerance;
    bool re_form = std::hypot(s.centre.x - formed.x, s.centre.y - formed.y) > kReform;
    if (re_form || !settled) sample(s.centre, re_form);
    if (settled && !trimmed) {
      trimmed = true;
      const std::size_t outliers = sums.largest > kTrim * kTrim ? trim() : 0;
      if (static_cast<double>(outliers) > kMaxTrim * pixels_) return std::nullopt;
      converged = outliers == 0;
      re_form = re_form || !converged;
      if (!converged) sample(s.centre, true);
    } else {
      converged = settled;
    }
    if (re_form) {
      formed = s.centre;
      factor.compute(normal_ = normal_matrix(prior));
    }
  }
  if (!converged) return std::nullopt;
  sums = layer_force(arrays_, light_, 0, arrays_.tiles);
  s.gain = light_.gain + light_.slope_x * (s.centre.x - x0_) + light_.slope_y * (s.centre.y - y0_);
  s.slope_x = light_.slope_x / s.gain;
  s.slope_y = light_.slope_y / s.gain;
  s.ground_gain = light_.ground;

  const Matrix inverse = inverse_of(normal_);
  fix.covariance = inverse.topLeftCorner<2, 2>();
  fix.slope_variance = 0.5 * (inverse(kSlopeX, kSlopeX) + inverse(kSlopeY, kSlopeY)) / (s.gain * s.gain);
  fix.chi_squared = sums.squares / std::max(1.0, sums.correlation.w);
  fix.ncc = sums.correlation.correlation();
  return fix;
}

ClusterPulls LayeredRegistration::cluster_pulls() {
  const Eigen::Matrix<double, 2, kLayerColumns> rows = inverse_of(normal_).topRows<2>();
  ClusterPulls out(clusters_, Eigen::Vector2f::Zero());
  for (std::size_t t = 0; t < arrays_.tiles; ++t) {
    const LayerForce sums = layer_force(arrays_, light_, t, t + 1);
    out[cluster_[t]] +=
        (rows * Eigen::Map<const Eigen::Matrix<double, kLayerColumns, 1>>(sums.force.data())).cast<float>();
  }
  return out;
}

/// The registration's own columns, then a change of size: all edges move outwards.
std::vector<TileSums> LayeredRegistration::tile_sums() const {
  const int n = kLayerColumns + 1;
  std::vector<TileSums> out;
  for (std::size_t t = 0; t < places_.size(); ++t) {
    TileSums sums{{places_[t].x + 0.5 * (kTile - 1), places_[t].y + 0.5 * (kTile - 1)},
                  Vector::Zero(n),
                  Matrix::Zero(n, n)};
    for (std::size_t i = t * kTilePixels; i < (t + 1) * kTilePixels; ++i) {
      if (!(counts_[i] > 0)) continue;
      const auto u = static_cast<double>(arrays_.u[i]), v = static_cast<double>(arrays_.v[i]);
      const auto step_x = static_cast<double>(arrays_.step_x[i]),
                 step_y = static_cast<double>(arrays_.step_y[i]);
      const double own = static_cast<double>(arrays_.part.value[i]) -
                         light_.mean * static_cast<double>(arrays_.share.value[i]);
      Eigen::Matrix<double, kLayerColumns, 1> own_columns;
      own_columns << step_x, step_y, own, own * u, own * v, static_cast<double>(arrays_.below[i]);
      Vector j(n);
      j << own_columns, u * step_x + v * step_y;
      const auto weight = static_cast<double>(arrays_.weight[i]);
      sums.score += weight * static_cast<double>(residual(i)) * j;
      sums.normal.selfadjointView<Eigen::Upper>().rankUpdate(j, weight);
    }
    sums.normal.triangularView<Eigen::StrictlyLower>() = sums.normal.transpose();
    out.push_back(std::move(sums));
  }
  return out;
}

std::optional<HalvesError> LayeredRegistration::halves() const {
  std::vector<TileSums> tiles = tile_sums();
  const int n = kLayerColumns + 1;
  Matrix normal = Matrix::Zero(n, n);
  Vector score = Vector::Zero(n);
  for (const TileSums& t : tiles) {
    normal += t.normal;
    score += t.score;
  }
  // What was known of the light beforehand.
  normal.topLeftCorner(n - 1, n - 1).diagonal() =
      normal.topLeftCorner(n - 1, n - 1).diagonal().cwiseMax(normal_.diagonal());
  const FewFactor factor(normal);
  const Vector step = factor.solve(score);
  if (!step.allFinite()) return std::nullopt;
  for (TileSums& t : tiles) t.score -= t.normal * step;
  return halves_error(tiles, normal, factor.solve(Matrix(Matrix::Identity(n, n))).topLeftCorner<2, 2>());
}

}  // namespace tribotrack::vision
