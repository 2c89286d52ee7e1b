#include "vision/edge/radius.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <vector>

#include "vision/discs/rim_steps.h"
#include "vision/edge/rays.h"
#include "vision/io/levels.h"
#include "vision/kernels/plane.h"
#include "vision/synthesis/camera.h"

namespace tribotrack::vision {
namespace {

constexpr double kShows = 3;       ///< px: three blurs of a lens that is as sharp as its pixels
constexpr double kWidest = 0.07;   ///< of the radius: chamfers of turned and punched parts reach so far
constexpr std::size_t kMost = 32;  ///< frames: their mean's noise is below what no field explains
constexpr double kCell = 0.5;      ///< px: as a quarter of one to some hundredths of a pixel of the edge
constexpr int kBeyondSeen = 4;     ///< px beyond the widest chamfer that are looked at
constexpr double kBorder = 8;      ///< px about the disc that its fit sees, or that an interpolation takes
constexpr double kCapture = 1;     ///< px; the track is far better
constexpr double kWhole = 0.8;     ///< of the rim; what covers more shows in the radius
/// Of the blur: what the edge's model, of one Gaussian, makes of frames that are smeared by different motion.
constexpr double kSmears = 0.005;
constexpr double kTransfer = 2.2;          ///< the light's exponent in stored levels, inverted
constexpr double kClearly = 1;             ///< -2 log L per ray: by less an edge may be none, on even ground
constexpr double kMoreWide = 0.5;          ///< px: what is as wide as can be is to be a minimum all the same
constexpr double kOffCentre[] = {1, 0.5};  ///< px: steps in which the outer edge's centre is looked for
constexpr double kOfBlur = 0.5;  ///< what the likelihood of fields that are not Gaussian leaves of an edge

enum class Seen { outer, other };  ///< which of a ring's edges is the edge that is seen

/// Rings of each width. The likelihood has a minimum for each of the edges that a ring's can be taken for:
/// half a pixel wide at the sharpest.
std::vector<RimOptics> rings(double widest, double blur, Seen seen) {
  std::vector<RimOptics> out;
  for (double width = 0; width <= widest; width += 0.5) {
    const double first = seen == Seen::outer ? -1 : width / 2 - 1, last = seen == Seen::outer ? 1 : width + 1;
    for (double edge = first; edge <= last; edge += 0.25) out.push_back({edge, blur, width});
  }
  return out;
}

/// About the part's centre, which lies at (middle, middle).
struct MeanPicture {
  Picture levels;
  int middle = 0;
  std::size_t frames = 0;
};

/// Of some of the frames that show all within `reach` px of the centre.
MeanPicture mean_about(FrameSource& source, const SeenFrames& frames, double reach) {
  MeanPicture mean{.levels = {}, .middle = static_cast<int>(std::ceil(reach))};
  const int size = 2 * mean.middle + 1;
  mean.levels = Picture(size, size);
  Picture picture, level(size, size);
  const std::size_t step = std::max<std::size_t>(1, frames.size() / kMost);
  for (std::size_t k = 0; k < frames.size(); k += step) {
    const Point& c = frames[k].centre;
    const Rect window = window_about(c, mean.middle + 1, source.bounds());
    if (window.width < size || window.height < size) continue;
    source.read(frames[k].index, window, picture);
    QuinticSpline(picture).sample_window(c.x - mean.middle - window.x, c.y - mean.middle - window.y, size,
                                         size, level.levels().data(), nullptr, nullptr);
    for (std::size_t i = 0; i < level.levels().size(); ++i) mean.levels.levels()[i] += level.levels()[i];
    ++mean.frames;
  }
  for (float& l : mean.levels.levels()) l /= static_cast<float>(std::max<std::size_t>(1, mean.frames));
  return mean;
}

/// The outer edge by the rays of the mean picture; nothing where no wide chamfer shows.
std::optional<OuterEdge> behind_a_ring(FrameSource& source, const SeenFrames& frames, double radius,
                                       double blur, double noise_variance, double chamfer) {
  const double widest = std::max(kWidest * radius, chamfer) + kMoreWide;
  RayGrid grid = ray_grid(radius);
  grid.outside = kBeyondSeen + static_cast<int>(std::ceil(widest));
  const MeanPicture mean = mean_about(source, frames, grid.reach() + kBorder);
  if (mean.frames == 0) return std::nullopt;
  const QuinticSpline spline(mean.levels);
  const RayFields fields(grid, kCell);
  RaySampler sampler(grid);
  std::vector<float> levels(grid.size());
  const auto likeliest = [&](const Point& centre, const std::vector<RimOptics>& starts, double most) {
    sampler.sample(spline, bounds_of(mean.levels), centre, {levels.data(), nullptr, nullptr});
    const RaySamples rays = samples_of_mean(grid, levels, noise_variance, mean.frames);
    return likeliest_optics(fields, {&rays, 1}, starts, RayFields::Beside::chamfer, most);
  };
  const Point seen{static_cast<double>(mean.middle), static_cast<double>(mean.middle)};
  Point centre = seen;
  LikeliestOptics best{{}, std::numeric_limits<double>::infinity()};
  const auto improves = [&](const Point& other, const std::vector<RimOptics>& starts) {
    const LikeliestOptics there = likeliest(other, starts, widest);
    if (!(there.cost < best.cost)) return false;
    best = there;
    centre = other;
    return true;
  };
  for (const double step : kOffCentre) {
    improves(centre, rings(widest, blur, Seen::other));
    for (bool moved = true; moved;) {
      moved = false;
      for (const auto& [x, y] : {std::pair{-step, 0.0}, {step, 0.0}, {0.0, -step}, {0.0, step}})
        moved |= improves({centre.x + x, centre.y + y}, {best.optics});
    }
  }
  improves(seen, rings(widest, blur, Seen::outer));
  const RimOptics& rim = best.optics;
  const double sharp = likeliest(centre, rings(0, blur, Seen::outer), 0).cost;
  if (!(rim.chamfer > kShows) || !(best.cost < sharp - kClearly)) return std::nullopt;
  return OuterEdge{
      rim.edge, kOfBlur * rim.blur, rim.chamfer, true, {centre.x - mean.middle, centre.y - mean.middle}};
}

/// kappa, for levels stored by the light's power.
double stored_shift(const DiscFit& fit, double black) {
  const double out = std::max(0.0, fit.outside - black), in = std::max(0.0, out + fit.contrast);
  const auto light = [](double level) { return std::pow(level, kTransfer); };
  return -normal_quantile((light(0.5 * (in + out)) - light(out)) / (light(in) - light(out)));
}

}  // namespace

std::optional<DiscFit> seen_edge(FrameSource& source, const SeenFrames& frames, double radius) {
  const MeanPicture mean = mean_about(source, frames, radius + std::max<double>(kBorder, 0.2 * radius));
  if (mean.frames < 2) return std::nullopt;
  const auto middle = static_cast<double>(mean.middle);
  auto fit = fit_disc(mean.levels, {middle, middle, radius}, kCapture, RimUse::mean_radius);
  if (!fit || fit->coverage < kWhole) return std::nullopt;
  fit->radius_sd = std::hypot(fit->radius_sd, kSmears * fit->blur);
  if (!source.info().colour) return fit;
  const double shift = stored_shift(*fit, source.info().black_level.value_or(0)) * fit->blur;
  fit->circle.radius -= 0.5 * shift;
  fit->common_sd = std::hypot(fit->common_sd, shift / std::sqrt(12.0));
  fit->radius_sd = std::hypot(fit->radius_sd, shift / std::sqrt(12.0));
  return fit;
}

OuterEdge outer_edge(FrameSource& source, const SeenFrames& frames, double radius, double blur,
                     double noise_variance, std::optional<double> chamfer) {
  const double w = chamfer.value_or(kWidest) * radius;
  if (w > kShows)
    if (const auto seen = behind_a_ring(source, frames, radius, blur, noise_variance, w)) return *seen;
  if (chamfer) return {0.5 * w, w / std::sqrt(8.0), w, false};
  const double widest = std::min(kWidest * radius, kShows);
  return {widest / 3, widest / std::sqrt(18.0), widest, false};
}

namespace {

constexpr double kInner = 0.6, kOuter = 1.5;  ///< of the radius: where the rim is looked for
constexpr double kHalfStep = 1.5;             ///< px: on both sides of an edge
constexpr int kRays = 72;

}  // namespace

std::optional<std::string> roundness_warning(const Picture& picture, const Circle& disc) {
  constexpr double kOfRadius = 0.03, kLeast = 0.5, kOfScatter = 5;  // kLeast: px
  const double reach = kOuter * disc.radius + kHalfStep + 1;
  if (disc.radius < 4 * kHalfStep || disc.x < reach || disc.y < reach ||
      disc.x + reach > picture.width() - 1 || disc.y + reach > picture.height() - 1)
    return std::nullopt;
  // Along each ray the place of the steepest edge that goes down outwards, and of that which goes up: the
  // disc's are the steeper ones.
  std::vector<double> radius[2];
  double steps[2] = {0, 0};
  for (const int way : {0, 1})
    for (const auto& [x, y] : directions(kRays)) {
      double place = 0, largest = 0;
      for (double r = kInner * disc.radius; r <= kOuter * disc.radius; r += 0.25) {
        const double step = (way == 0 ? 1 : -1) * rim_step(picture, {disc.x, disc.y, r}, kHalfStep, {x, -y});
        if (step <= largest) continue;
        largest = step;
        place = r;
      }
      radius[way].push_back(place);
      steps[way] += largest;
    }
  const std::vector<double>& seen = radius[steps[1] > steps[0]];
  std::complex<double> harmonic[3];
  double square = 0;
  for (int k = 0; k < kRays; ++k) {
    for (int n = 0; n < 3; ++n)
      harmonic[n] +=
          seen[static_cast<std::size_t>(k)] / kRays * std::polar(1.0, 2 * std::numbers::pi * n * k / kRays);
    square += seen[static_cast<std::size_t>(k)] * seen[static_cast<std::size_t>(k)] / kRays;
  }
  const double mean = harmonic[0].real(), amplitude = 2 * std::abs(harmonic[2]);
  const double rest = std::sqrt(
      std::max(0.0, square - mean * mean - 2 * std::norm(harmonic[1]) - 2 * std::norm(harmonic[2])));
  if (!(amplitude > std::max(kLeast, kOfRadius * mean)) ||
      !(amplitude > kOfScatter * rest / std::sqrt(0.5 * kRays)))
    return std::nullopt;
  return fmt::format(
      "the disc is seen as an ellipse: its axes differ by {:.0f} %, the longer one at {:.0f} degrees; pixels "
      "that are "
      "not square, or a camera that looks from the side, put scale and alpha off by as much",
      200 * amplitude / mean, std::arg(harmonic[2]) / 2 * 180 / std::numbers::pi);
}

}  // namespace tribotrack::vision
