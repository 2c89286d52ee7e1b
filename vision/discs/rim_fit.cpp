#include "vision/discs/rim_fit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "vision/discs/mean_radius.h"
#include "vision/discs/rim_model.h"
#include "vision/io/levels.h"
#include "vision/kernels/median.h"

namespace tribotrack::vision {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr std::array<int, 4> kCurved = {7, 8, 9, 13};  ///< that only large discs have
constexpr double kCurvedRadius = 12;     ///< px; smaller discs have too few pixels inside their rim
constexpr double kCurvedMeanRadius = 7;  ///< px; likewise for the mean radius
constexpr double kSectorRadius = 5;      ///< px; smaller rims have too few pixels for sectors
constexpr int kRounds = 4;               ///< of weights, the first all alike
constexpr int kRoundsFromNear = 2;       ///< where the start already yields the weights
constexpr int kSteps = 25;               ///< for given weights, at most
constexpr double kTukey = 6;             ///< sd: what is further off does not count

/// Normal matrix, gradient and cost; what small discs do not have is held.
RimSums normal_equations(const RimParameters& p, const RimPixels& pixels, bool curved) {
  RimSums sums = rim_sums(p, pixels);
  if (!curved)
    for (const int i : kCurved) {
      sums.normal.row(i).setZero();
      sums.normal.col(i).setZero();
      sums.normal(i, i) = 1;
      sums.gradient(i) = 0;
    }
  return sums;
}

/// For given weights, from p, which it changes. Returns the last normal matrix.
RimCovariance settle(RimParameters& p, const RimPixels& pixels, bool curved, double tolerance,
                     double& damping) {
  RimSums at = normal_equations(p, pixels, curved);
  for (int k = 0; k < kSteps; ++k) {
    bool improved = false;
    for (int tries = 0; tries < 8 && !improved; ++tries) {
      RimCovariance damped = at.normal;
      damped.diagonal() *= 1 + damping;
      const RimParameters step = damped.ldlt().solve(at.gradient);
      RimParameters trial = p + step;
      trial(3) = std::clamp(trial(3), 0.3, 0.5 * std::max(1.0, trial(2)));
      if (step.head<4>().cwiseAbs().maxCoeff() < tolerance) {
        p = trial;
        return at.normal;
      }
      if (trial(2) > 1) {
        RimSums there = normal_equations(trial, pixels, curved);
        improved = there.cost <= at.cost;
        if (improved) {
          p = trial;
          at = there;
        }
      }
      damping = improved ? std::max(1e-9, damping / 10) : damping * 10;
    }
    if (!improved) break;
  }
  return at.normal;
}

struct Influence {
  double weight = 0, square = 0, slope = 0;  ///< sums of w, psi^2, psi'
  double weighted_square = 0;
};

/// Tukey's weights by the pixels' residuals.
Influence weigh(const std::vector<double>& residuals, RimPixels& pixels) {
  std::vector<double> sizes(residuals.size());
  std::ranges::transform(residuals, sizes.begin(), [](double r) { return std::abs(r); });
  const double scale = std::max(0.3, kNormalMad * median(sizes));
  Influence sums;
  for (std::size_t i = 0; i < residuals.size(); ++i) {
    const double t = residuals[i] / (kTukey * scale), rest = std::max(0.0, 1 - t * t);
    const double weight = rest * rest, square = residuals[i] * residuals[i];
    pixels.weight[i] = weight;
    sums.weight += weight;
    sums.weighted_square += weight * square;
    sums.square += weight * weight * square;
    sums.slope += rest * (1 - 5 * t * t);
  }
  return sums;
}

/// What the residuals of each sector of the rim do to the radius: -(N^-1 sum w g r)_R.
std::vector<double> sector_pull(const RimPixels& pixels, const RimParameters& p,
                                const RimCovariance& inverse_normal) {
  if (p(2) < kSectorRadius) return {};
  const std::vector<double> pulls = rim_pulls(p, pixels, inverse_normal.row(2));
  std::vector<double> pull(kSectors, 0);
  for (std::size_t i = 0; i < pulls.size(); ++i) {
    const double turn = 0.5 + std::atan2(pixels.y[i] - p(1), pixels.x[i] - p(0)) / (2 * kPi);
    pull[std::min(static_cast<std::size_t>(turn * kSectors), kSectors - 1)] += pulls[i];
  }
  return pull;
}

}  // namespace

RimPixels rim_pixels(const Picture& picture, const Circle& c, double band) {
  RimPixels pixels;
  const auto expected = static_cast<std::size_t>(std::max(0.0, 4.2 * kPi * c.radius * band) + 64);
  for (auto* v : {&pixels.x, &pixels.y, &pixels.level}) v->reserve(expected);
  const double reach = c.radius + band;
  const int x0 = std::max(0, static_cast<int>(std::floor(c.x - reach)));
  const int x1 = std::min(picture.width() - 1, static_cast<int>(std::ceil(c.x + reach)));
  const int y0 = std::max(0, static_cast<int>(std::floor(c.y - reach)));
  const int y1 = std::min(picture.height() - 1, static_cast<int>(std::ceil(c.y + reach)));
  const double least = std::pow(std::max(0.0, c.radius - band), 2), most = reach * reach;
  for (int y = y0; y <= y1; ++y) {
    const float* row = picture.row(y).data();
    const double across = (y - c.y) * (y - c.y);
    // Left of the inner circle and right of it; without one, all at once.
    const double half = across < least ? std::sqrt(least - across) : 0;
    const int left = std::clamp(static_cast<int>(std::ceil(c.x - half)) + 1, x0, x1 + 1);
    const int right = std::clamp(static_cast<int>(std::floor(c.x + half)) - 1, left, x1 + 1);
    const auto add = [&](int from, int to) {
      for (int x = from; x < to; ++x) {
        const double square = (x - c.x) * (x - c.x) + across;
        if (square < least || square > most) continue;
        pixels.x.push_back(x);
        pixels.y.push_back(y);
        pixels.level.push_back(static_cast<double>(row[x]));
      }
    };
    add(x0, left);
    add(right, x1 + 1);
  }
  pixels.weight.assign(pixels.x.size(), 1);
  return pixels;
}

bool rim_curves(const RimParameters& p, RimUse use) {
  return p(2) >= (use == RimUse::place ? kCurvedRadius : kCurvedMeanRadius);
}

double rim_band(const RimParameters& p, bool curved) {
  const double band = std::min(std::clamp(4.5 * p(3), 4.0, 30.0), 0.6 * p(2));
  // The slope of a level that may curve must be fixed by pixels.
  return curved ? std::max(band, std::min(std::clamp(6.5 * p(3), 5.5, 30.0), 0.35 * p(2))) : band;
}

RimFit fit_rim(RimPixels& pixels, const RimParameters& start, bool curved, const RimFitOptions& options) {
  RimFit fit;
  fit.p = start;
  double damping = options.damping;
  RimCovariance normal;
  Influence influence;
  const int rounds = options.from_near ? kRoundsFromNear : kRounds;
  if (options.from_near) weigh(rim_residuals(fit.p, pixels), pixels);
  for (int round = 0; round < rounds; ++round) {
    normal =
        settle(fit.p, pixels, curved, round + 1 < rounds ? options.on_the_way : options.tolerance, damping);
    influence = weigh(rim_residuals(fit.p, pixels), pixels);
  }
  fit.residual_rms = std::sqrt(influence.weighted_square / std::max(1.0, influence.weight - kRimParameters));
  const RimCovariance inverse_normal = normal.ldlt().solve(RimCovariance::Identity());
  // Huber (1981): with psi = w r the covariance is E[psi^2] / E[psi']^2 (sum g g^T)^-1, g the slopes.
  const auto count = static_cast<double>(pixels.x.size());
  const double gain = influence.weight / std::max(1.0, influence.slope);
  fit.covariance = inverse_normal * gain * gain * (influence.square / influence.weight) * count /
                   std::max(1.0, count - kRimParameters);
  fit.sector_pull = sector_pull(pixels, fit.p, inverse_normal);
  for (double& pull : fit.sector_pull) pull *= gain;
  return fit;
}

namespace {

constexpr double kMargin = 8;         ///< px around the disc that the rim's fit sees
constexpr double kCapture = 1;        ///< px; the track is far better
constexpr double kMinCoverage = 0.8;  ///< share of the rim; what covers more shows in the radius
/// What of a smear the rim's model, whose blur is the same all round, takes for radius: a smear of 5 blurs.
constexpr double kSmearSlope = 0.02;
constexpr double kTransfer = 2.2;  ///< the light's exponent in stored levels, inverted

/// t with Phi(t) = share.
double normal_quantile(double share) {
  double low = -6, high = 6;
  while (high - low > 1e-9) {
    const double middle = 0.5 * (low + high);
    (normal_step(middle).value < share ? low : high) = middle;
  }
  return low;
}

/// How far outside its place the middle of an edge is stored, in blurs, were levels stored by kTransfer.
double stored_shift(const DiscFit& fit, double black) {
  const RimParameters p = Eigen::Map<const RimParameters>(fit.rim.data());
  const double out = std::max(0.0, p(kRimOutside) + p(kRimOutside + 3) - black);
  const double in = std::max(0.0, out + fit.contrast);
  const auto light = [](double level) { return std::pow(level, kTransfer); };
  const double share = (light(0.5 * (in + out)) - light(out)) / (light(in) - light(out));
  return -normal_quantile(share);
}

struct Estimate {
  double value = 0, variance = 0;
};

Estimate combined(const Estimate& a, const Estimate& b) {
  const double weight = a.variance / (a.variance + b.variance);
  return {a.value + weight * (b.value - a.value), weight * b.variance};
}

/// One frame's rim, and how fast the disc was.
struct Seen {
  const DiscFit* fit;
  double speed;
};

/// Slope of the radius over the blur as far as both go with the square of the speed: what else the blur is
/// off by, the radius is too, and for other reasons.
Estimate slope_over_blur(const std::vector<Seen>& frames, double mean_radius, double mean_blur) {
  const auto count = static_cast<double>(frames.size());
  double middle = 0, squares = 0, radii = 0, blurs = 0, left = 0;
  for (const Seen& f : frames) middle += f.speed * f.speed / count;
  for (const Seen& f : frames) {
    const double z = f.speed * f.speed - middle;
    squares += z * z;
    radii += z * (f.fit->circle.radius - mean_radius);
    blurs += z * (f.fit->blur - mean_blur);
  }
  if (count < 4 || blurs == 0) return {0, 1e9};
  const double slope = radii / blurs;
  for (const Seen& f : frames)
    left += std::pow(f.fit->circle.radius - mean_radius - slope * (f.fit->blur - mean_blur), 2);
  return {slope, left / (count - 2) * squares / (blurs * blurs)};
}

/// The radius that the same frames would show at rest, and of levels that are not linear in the light without
/// blur. From the frames' blur to that of the sharpest the slope is seen; from there to none it is supposed.
MeanRadius without_blur(MeanRadius mean, const std::vector<Seen>& frames, bool curved_levels, double black) {
  const auto count = static_cast<double>(frames.size());
  double blur = 0, shift = 0, scatter = 0, sharpest = 1e9;
  for (const Seen& f : frames) {
    blur += f.fit->blur / count;
    sharpest = std::min(sharpest, f.fit->blur);
    if (curved_levels) shift += stored_shift(*f.fit, black) / count;
    scatter += std::pow(f.fit->circle.radius - mean.radius, 2) / count;
  }
  const Estimate supposed{0.5 * shift, shift * shift / 12};
  const Estimate smear = combined({supposed.value, supposed.variance + kSmearSlope * kSmearSlope},
                                  slope_over_blur(frames, mean.radius, blur));
  const double common = std::sqrt(supposed.variance) * sharpest;
  mean.radius -= smear.value * (blur - sharpest) + supposed.value * sharpest;
  mean.sd = std::hypot(mean.sd, std::sqrt(smear.variance) * (blur - sharpest), common);
  if (curved_levels) mean.sd = std::hypot(mean.sd, std::sqrt(scatter / count));
  mean.common_sd = std::hypot(mean.common_sd, common);
  return mean;
}

}  // namespace

bool in_sample(std::int64_t n, std::int64_t stride) {
  return n % stride == 0 || (n < stride && (n & (n - 1)) == 0);
}

RimWatch::RimWatch(const Circle& disc, std::int64_t stride, std::optional<DiscFit> start)
    : disc_(disc), stride_(std::max<std::int64_t>(1, stride)), last_(std::move(start)) {}

void RimWatch::see(FrameSource& source, std::int64_t index, Point centre) {
  if (disc_.radius <= 0) return;
  const double speed = seen_ > 0 && index > last_index_
                           ? std::hypot(centre.x - last_centre_.x, centre.y - last_centre_.y) /
                                 static_cast<double>(index - last_index_)
                           : 0;
  last_index_ = index;
  last_centre_ = centre;
  if (!in_sample(seen_++, stride_)) return;
  curved_levels_ = source.info().colour;
  black_ = source.info().black_level.value_or(0);
  const double reach = disc_.radius + std::max(kMargin, 0.2 * disc_.radius);
  const Rect window = window_about(centre, reach, source.bounds());
  if (window.width < 2 * disc_.radius || window.height < 2 * disc_.radius) return;
  Picture picture;
  source.read(index, window, picture);
  const Point here{centre.x - window.x, centre.y - window.y};
  std::optional<DiscFit> fit;
  if (last_) fit = refit_disc(picture, *last_, here, kCapture);
  if (!fit || fit->coverage < kMinCoverage) {
    fit = fit_disc(picture, {here.x, here.y, disc_.radius}, kCapture);
    if (fit) fit = refit_disc(picture, *fit, {fit->circle.x, fit->circle.y}, kCapture);
  }
  if (!fit || fit->coverage < kMinCoverage) return;
  last_ = fit;
  fits_.push_back(std::move(*fit));
  speeds_.push_back(speed);
}

std::optional<MeanRadius> RimWatch::radius() const {
  if (fits_.size() < 2) return std::nullopt;
  std::vector<double> radii;
  for (const DiscFit& fit : fits_) radii.push_back(fit.circle.radius);
  const double middle = median(radii);
  for (double& r : radii) r = std::abs(r - middle);
  const double limit = 5 * kNormalMad * median(radii) + 1e-6;
  std::vector<DiscFit> kept;
  std::vector<Seen> seen;
  for (std::size_t k = 0; k < fits_.size(); ++k) {
    if (!(std::abs(fits_[k].circle.radius - middle) <= limit)) continue;
    kept.push_back(fits_[k]);
    seen.push_back({&fits_[k], speeds_[k]});
  }
  const MeanRadius mean = mean_radius(kept);
  return without_blur(mean, seen, curved_levels_, black_);
}

}  // namespace tribotrack::vision
