#include "vision/discs/mean_radius.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "vision/io/window.h"
#include "vision/kernels/median.h"

namespace tribotrack::vision {
namespace {

constexpr double kMargin = 8;         ///< px around the disc that the rim's fit sees
constexpr double kCapture = 1;        ///< px; the track is far better
constexpr double kMinCoverage = 0.9;  ///< share of the rim

}  // namespace

RimWatch::RimWatch(const Circle& disc, std::int64_t stride, std::optional<DiscFit> start)
    : disc_(disc), stride_(std::max<std::int64_t>(1, stride)), last_(std::move(start)) {}

void RimWatch::see(FrameSource& source, std::int64_t index, Point centre) {
  if (disc_.radius <= 0 || seen_++ % stride_ != 0) return;
  const double reach = disc_.radius + std::max(kMargin, 0.2 * disc_.radius);
  const Rect window = window_about(centre, reach, source.bounds());
  if (window.width < 2 * disc_.radius || window.height < 2 * disc_.radius) return;
  Picture picture;
  source.read(index, window, picture);
  const Point here{centre.x - window.x, centre.y - window.y};
  std::optional<DiscFit> fit;
  if (last_) fit = refit_disc(picture, *last_, here, kCapture);
  if (!fit || fit->coverage < kMinCoverage) fit = fit_disc(picture, {here.x, here.y, disc_.radius}, kCapture);
  if (!fit || fit->coverage < kMinCoverage) return;
  last_ = fit;
  fits_.push_back(std::move(*fit));
}

std::optional<MeanRadius> RimWatch::radius() const {
  if (fits_.size() < 2) return std::nullopt;
  std::vector<double> radii;
  for (const DiscFit& fit : fits_) radii.push_back(fit.circle.radius);
  const double middle = median(radii);
  for (double& r : radii) r = std::abs(r - middle);
  const double limit = 5 * kNormalMad * median(radii) + 1e-6;
  std::vector<DiscFit> kept;
  for (const DiscFit& fit : fits_)
    if (std::abs(fit.circle.radius - middle) <= limit) kept.push_back(fit);
  return mean_radius(kept);
}

}  // namespace tribotrack::vision
