#include "vision/discs/mean_radius.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "vision/discs/rim_fit.h"
#include "vision/io/levels.h"
#include "vision/kernels/median.h"

namespace tribotrack::vision {
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
    (0.5 * std::erfc(-middle / std::numbers::sqrt2) < share ? low : high) = middle;
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
