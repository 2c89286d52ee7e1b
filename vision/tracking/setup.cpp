#include "vision/tracking/setup.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "vision/io/levels.h"
#include "vision/kernels/median.h"
#include "vision/registration/registration.h"
#include "vision/rotation/rotation.h"

namespace tribotrack::vision {
namespace {

constexpr double kClickSd = 0.5;         ///< px: sd of a radius that no rim confirms
constexpr double kRotationLimit = 0.05;  ///< rad: rotation that is known less well is not estimated
constexpr double kClear = 4;             ///< px beside the rim, at least, that the disc's blur reaches
constexpr double kTextureFactor = 2;  ///< platform texture above this multiple of the noise narrows the mask

/// Texture of the ground around the disc, grey levels rms beyond noise: what a wider mask would include.
/// Levels far from the median, a neighbour or a shadow, do not count.
double ground_texture(const Picture& first, const Circle& disc, double blur, double noise_variance) {
  std::vector<float> levels;
  const double inner = disc.radius + std::max(kClear, 4 * blur);
  const double outer = std::max(inner + kClear, disc.radius + 0.25 * disc.radius);
  for (int y = std::max(0, static_cast<int>(disc.y - outer));
       y <= std::min(first.height() - 1, static_cast<int>(disc.y + outer)); ++y)
    for (int x = std::max(0, static_cast<int>(disc.x - outer));
         x <= std::min(first.width() - 1, static_cast<int>(disc.x + outer)); ++x) {
      const double rho = std::hypot(x - disc.x, y - disc.y);
      if (rho >= inner && rho <= outer) levels.push_back(first.at(x, y));
    }
  if (levels.size() < 20) return 0;
  const float centre = median(levels);
  for (float& level : levels) level = std::abs(level - centre);
  // The median of whole levels is coarse: good enough to reject outliers, not for the texture itself.
  const double outlier = 4 * std::max(1.0, kNormalMad * median(levels));
  double squares = 0;
  double count = 0;
  for (const float level : levels)
    if (level <= outlier) {
      squares += static_cast<double>(level) * level;
      ++count;
    }
  return std::sqrt(std::max(0.0, squares / count - noise_variance));
}

void set_up_rectangle(PartSetup& setup, const Picture& first, const FrameSource& source, const Rect& r) {
  if (r.width < 8 || r.height < 8 || !source.bounds().contains(r))
    throw InputError(fmt::format(
        "{}: the template {},{},{},{} must be at least 8 x 8 px and lie inside the {} x {} picture",
        source.info().path.string(), r.x, r.y, r.width, r.height, first.width(), first.height()));
  setup.pattern = rectangle_pattern(r);
  setup.result.disc = {setup.pattern.centre.x, setup.pattern.centre.y, 0};
}

void locate_disc(PartSetup& setup, const Picture& first, const FrameSource& source, const Appearance& seen,
                 const TrackOptions& options, TrackSummary& summary) {
  if (options.target.kind == Target::Kind::disc) {
    check_whole(first, options.target.disc, source, "disc");
    setup.rim = seen.discs.empty() ? refined(first, options.target.disc) : seen.discs.front();
    if (!setup.rim) summary.warnings.push_back(no_rim_warning("disc", options.target.disc));
  } else {
    setup.rim = find_part(first, source, seen, options);
  }
  setup.result.disc = setup.rim ? setup.rim->circle : options.target.disc;
  summary.disc_radius_sd = setup.rim ? setup.rim->radius_sd : kClickSd;
  summary.disc_blur = setup.rim ? setup.rim->blur : 0;
}

/// A textured ground around the disc moves against it: then the mask ends at the rim.
void mask_disc(PartSetup& setup, const Picture& first, double noise_variance, TrackSummary& summary) {
  const double noise = std::sqrt(noise_variance);
  const Circle& disc = setup.result.disc;
  const double texture = setup.result.ground_texture =
      ground_texture(first, disc, summary.disc_blur, noise_variance);
  const bool beyond_rim = !(texture > kTextureFactor * noise);
  setup.pattern = disc_pattern(first, disc, beyond_rim ? 3 : 0);
  summary.plan.push_back(
      {.name = "mask beyond the rim",
       .on = beyond_rim,
       .reason = fmt::format(
           "the ground around the disc has a texture of {:.1f} grey levels rms against noise of {:.1f}",
           texture, noise)});
}

void decide_rotation(PartSetup& setup, double noise_variance, const Picture& first, FrameSource& source,
                     const FrameRange& range, TrackSummary& summary) {
  constexpr double kAnyAngle = 10;  // rad: rotation is not visible at all
  const Pattern& part = setup.pattern;
  const double radius =
      part.radius > 0 ? part.radius : 0.5 * std::hypot(part.window.width, part.window.height);
  const double limit =
      rotation_limit(first, {part.centre.x, part.centre.y, radius}, summary.disc_blur, noise_variance);
  const bool visible = limit < kRotationLimit;
  const bool on = visible && (part.radius == 0 || texture_returns(source, first, range.first, range.last,
                                                                  part, summary.disc_blur, setup.follow));
  setup.result.texture_seen = visible;
  setup.result.turning = setup.follow.rotation = on;
  summary.plan.push_back(
      {.name = "rotation",
       .on = on,
       .reason =
           visible && !on ? "what looks like a texture of the part is not seen again in the following frames"
           : limit < kAnyAngle ? fmt::format("the part's texture shows its rotation to {:.3g} rad", limit)
                               : "the part has no texture above the noise that shows rotation"});
}

/// The template is averaged over the first frames where its noise matters: a single one's adds `noise_cost`
/// to the variance, relative.
void average_template(PartSetup& setup, double noise_cost, const Picture& first, FrameSource& source,
                      const FrameRange& range, TrackSummary& summary) {
  PlanStage stage{.name = "template averaged over the first frames",
                  .reason = "the part may turn: frames cannot be averaged",
                  .error_bound_px = setup.result.limit_px * (std::sqrt(1 + noise_cost) - 1)};
  if (!setup.follow.rotation) {
    setup.average =
        quiet_template(source, first, range.first, range.last, setup.pattern, noise_cost, setup.follow);
    stage.on = setup.average.frames > 1;
    stage.reason =
        fmt::format("the noise of a single template adds {:.2g} % to the variance", 100 * noise_cost);
    if (!(noise_cost < kQuietTemplate))
      stage.reason += fmt::format("; {} frames agree", setup.average.frames);
  }
  summary.plan.push_back(std::move(stage));
}

/// What the first pass and those after it go by. A disc given without a rim that confirms it still has one to
/// measure.
void look_at_rim(PartSetup& setup, const Picture& first) {
  if (setup.pattern.radius > 0 && !setup.rim) setup.rim = fit_disc(first, setup.result.disc, 1);
  if (!setup.rim) return;
  const DiscFit& rim = *setup.rim;
  setup.result.blur = rim.blur;
  setup.result.contrast = std::abs(rim.contrast);
  const auto sectors = measure_rim_sectors(first, rim.circle, rim.blur);
  if (!sectors) return;
  const RimShape shape = shape_of(*sectors, rim.blur, {rim.circle.x, rim.circle.y});
  if (same_rim(*sectors, shape)) setup.shape = shape;
}

}  // namespace

PartSetup set_up_part(const Picture& first, FrameSource& source, const FrameRange& range,
                      const Appearance& seen, const TrackOptions& options, double noise_variance,
                      TrackSummary& summary) {
  PartSetup setup;
  setup.follow.min_ncc = options.min_ncc;
  setup.follow.noise_variance = noise_variance;
  setup.result.first_index = range.first;
  setup.result.total = range.count();
  setup.result.noise_variance = noise_variance;
  if (options.target.kind == Target::Kind::rectangle) {
    set_up_rectangle(setup, first, source, options.target.rectangle);
  } else {
    locate_disc(setup, first, source, seen, options, summary);
    mask_disc(setup, first, noise_variance, summary);
  }
  const TemplateRegistration trial(first, setup.pattern, setup.follow);
  setup.result.limit_px = std::sqrt(0.5 * trial.limit().trace());
  decide_rotation(setup, noise_variance, first, source, range, summary);
  average_template(setup, trial.template_noise_cost(), first, source, range, summary);
  look_at_rim(setup, first);
  summary.disc = setup.result.disc;
  summary.limit_px = setup.result.limit_px;
  summary.noise_levels = std::sqrt(noise_variance);
  return setup;
}

// Whole pictures are large: never more than three at a time.
Camera check_camera(FrameSource& source, const FrameRange& range) {
  const std::int64_t last = std::min(range.last, range.first + kCameraFrames - 1);
  const Picture first = source.read(range.first);
  const Picture* before = &first;
  std::array<Picture, 2> others;
  NoiseEstimate estimate;
  for (std::int64_t k = range.first + 1; k <= last; ++k) {
    Picture& now = others[static_cast<std::size_t>(k % 2)];
    source.read(k, source.bounds(), now);
    estimate.add_pair(*before, now);
    before = &now;
  }
  Camera camera{estimate.variance(first), {}};
  BadPixelSearch search(first, camera.noise_variance);
  for (std::int64_t k = range.first + 1; k <= last && !search.settled(); ++k) {
    source.read(k, source.bounds(), others[0]);
    search.look(others[0]);
  }
  camera.bad_pixels = search.found();
  return camera;
}

namespace {

constexpr float kNotKnown = std::numeric_limits<float>::quiet_NaN();
constexpr int kContext = 4;  ///< px shown about the template

/// The camera's pixels about the template at a pose.
Rect window_at(const Pattern& pattern, const Pose& pose, const Rect& bounds) {
  const Rect& w = pattern.window;
  const double x = w.x + pose.dx - kContext, y = w.y + pose.dy - kContext;
  return touched_pixels(x, y, x + w.width - 1 + 2 * kContext, y + w.height - 1 + 2 * kContext, bounds);
}

/// gain T + offset over a window of the camera, not known where the mask has no weight.
Picture predicted(const TemplateRegistration& registration, const Registration& fix, const Rect& window) {
  const Pattern& pattern = registration.pattern();
  Picture out = registration.at(fix.pose, window);
  for (int y = 0; y < window.height; ++y)
    for (int x = 0; x < window.width; ++x) {
      const int i = static_cast<int>(std::lround(window.x + x - fix.pose.dx)) - pattern.window.x;
      const int j = static_cast<int>(std::lround(window.y + y - fix.pose.dy)) - pattern.window.y;
      const bool in_mask = i >= 0 && j >= 0 && i < pattern.window.width && j < pattern.window.height &&
                           pattern.weights.at(i, j) > 0;
      const double level = fix.gain * static_cast<double>(out.at(x, y)) + fix.offset;
      out.at(x, y) = in_mask ? static_cast<float>(level) : kNotKnown;
    }
  return out;
}

}  // namespace

void show_first_pass(const PartSetup& part, const Picture& first, const Track& track,
                     const ShownFrames& frames, FrameSource& source, DebugSink& sink) {
  TemplateRegistration registration(part.average.picture(first), part.pattern, part.follow);
  const Rect& whole = part.pattern.window;
  sink.show(StagePicture{
      .name = "first_pass_template",
      .title = "template of the first pass, average of " + std::to_string(part.average.frames) + " frame(s)",
      .why_frame = "where the part is in the first frame",
      .levels = registration.at({}, whole),
      .first = {static_cast<double>(whole.x), static_cast<double>(whole.y)},
      .place = "of the camera"});
  for (const auto& shown : frames) {
    const auto place = static_cast<std::size_t>(shown.first - part.result.first_index);
    const TrackPoint& point = track.points[place];
    const Pose pose{point.x - part.pattern.centre.x, point.y - part.pattern.centre.y,
                    part.result.looks[place].theta};
    const Rect window = window_at(part.pattern, pose, source.bounds());
    const StagePicture seen = window_of(source, shown, window);
    const Registration fix = registration.refine(seen.levels, window.x, window.y, pose);
    sink.show(seen);
    show_prediction(seen, predicted(registration, fix, window), "first_pass",
                    "the template at the measured place, its gain and offset fitted",
                    "first pass: camera minus prediction", sink);
  }
}

}  // namespace tribotrack::vision
