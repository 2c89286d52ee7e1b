#include "vision/tracking/setup.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "vision/following/texture_check.h"

namespace tribotrack::vision {
namespace {

constexpr double kRotationLimit = 0.05;  ///< rad: a texture that shows less does not show rotation
constexpr double kClear = 4;             ///< px beside the rim, at least, that show the disc's halo
constexpr double kTextureFactor = 2;  ///< platform texture above this multiple of the noise narrows the mask

/// Texture of the ground around the disc, grey levels rms beyond noise: what a wider mask would let in. What
/// lies far outside the median deviation, a neighbour or a shadow, does not count.
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
  const auto median = [&] {
    const auto middle = levels.begin() + static_cast<std::ptrdiff_t>(levels.size() / 2);
    std::nth_element(levels.begin(), middle, levels.end());
    return *middle;
  };
  const float centre = median();
  for (float& level : levels) level = std::abs(level - centre);
  // The median of whole levels is coarse: it only says which pixels are strangers.
  const double stranger = 4 * std::max(1.0, 1.4826 * median());
  double squares = 0;
  double count = 0;
  for (const float level : levels)
    if (level <= stranger) {
      squares += static_cast<double>(level) * level;
      ++count;
    }
  return std::sqrt(std::max(0.0, squares / count - noise_variance));
}

/// Pixels of the template, those that take part, and the window that is read about a prediction.
PlanCosts costs_of(const Pattern& pattern, const TemplateRegistration& registration) {
  constexpr int kMargin = 10;
  PlanCosts costs;
  for (const float weight : pattern.weights.levels()) costs.mask_pixels += weight > 0;
  costs.part_pixels = costs.mask_pixels * registration.pixel_share();
  costs.window_pixels = (pattern.window.width + kMargin) * (pattern.window.height + kMargin);
  return costs;
}

}  // namespace

Setup plan_part(const Picture& first, FrameSource& source, const FrameRange& range,
                const TrackOptions& options, double noise_variance, TrackSummary& summary) {
  Setup setup;
  setup.follow.min_ncc = options.min_ncc;
  setup.follow.noise_variance = noise_variance;
  setup.follow.search_margin_px = options.search_margin_px;
  if (options.target.kind == Target::Kind::rectangle) {
    const Rect& r = options.target.rectangle;
    if (r.width < 8 || r.height < 8 || !source.bounds().contains(r))
      throw InputError(fmt::format(
          "{}: the template {},{},{},{} must be at least 8 x 8 px and lie inside the {} x {} "
          "picture",
          source.info().path.string(), r.x, r.y, r.width, r.height, first.width(), first.height()));
    setup.pattern = rectangle_pattern(r);
    summary.disc = {setup.pattern.centre.x, setup.pattern.centre.y, 0};
  } else {
    if (options.target.kind == Target::Kind::disc) {
      check_whole(first, options.target.disc, source, "disc");
      setup.rim = refined(first, options.target.disc, "disc", summary);
    } else {
      setup.rim = find_part(first, source, options);
    }
    summary.disc = setup.rim ? setup.rim->circle : options.target.disc;
    summary.disc_radius_sd = setup.rim ? setup.rim->radius_sd : kClickSd;
    summary.disc_blur = setup.rim ? setup.rim->blur : 0;
    const double texture = ground_texture(first, summary.disc, summary.disc_blur, noise_variance);
    setup.ground_texture = texture;
    const bool busy = texture > kTextureFactor * std::sqrt(noise_variance);
    DiscPatternOptions mask;
    mask.margin_px = busy ? 0 : 3;
    setup.pattern = disc_pattern(first, summary.disc, mask);
    summary.plan.push_back(
        {"mask beyond the rim", !busy,
         fmt::format("the ground around the disc has a texture of {:.1f} grey levels rms against "
                     "noise of {:.1f}",
                     texture, std::sqrt(noise_variance)),
         0, 0, 0});
  }
  RegistrationOptions probe;
  probe.noise_variance = noise_variance;
  const TemplateRegistration trial(first, setup.pattern, probe);
  const bool shown = trial.limit_theta() < kRotationLimit;
  setup.follow.rotation =
      shown && (setup.pattern.radius == 0 ||
                texture_returns(source, first, range.first, range.last, setup.pattern, setup.follow));
  setup.template_noise_cost = trial.template_noise_cost();
  setup.costs = costs_of(setup.pattern, trial);
  summary.limit_px = std::sqrt(0.5 * trial.limit().trace());
  summary.plan.push_back(
      {"rotation", setup.follow.rotation,
       shown && !setup.follow.rotation
           ? std::string(
                 "what looks like a texture of the part does not come again in the frames that follow")
       : trial.limit_theta() < 10
           ? fmt::format("the part's texture shows its rotation to {:.3g} rad", trial.limit_theta())
           : std::string("the part has no texture above the noise that shows rotation"),
       0, 0, setup.costs.rotation()});
  return setup;
}

AveragedTemplate quiet_template(FrameSource& source, const Picture& first, const FrameRange& range,
                                Setup& setup, TrackSummary& summary) {
  const double cost = 100 * setup.template_noise_cost;
  AveragedTemplate average;
  std::string reason;
  if (setup.follow.rotation) {
    reason = "the part may turn: frames are not laid on each other";
  } else if (setup.template_noise_cost < kQuietTemplate) {
    reason = fmt::format("the noise of a single template adds {:.2g} % to the variance", cost);
  } else {
    average = average_template(source, first, range.first, range.last, setup.pattern, setup.follow);
    setup.follow.template_noise_share = 1.0 / average.frames;
    reason = fmt::format("the noise of a single template adds {:.2g} % to the variance; {} frames agree",
                         cost, average.frames);
  }
  summary.plan.push_back({"template averaged over the first frames", average.frames > 1, reason, 0,
                          summary.limit_px * (std::sqrt(1 + setup.template_noise_cost) - 1),
                          setup.costs.averaging(TemplateAverageOptions{}.frames)});
  return average;
}

}  // namespace tribotrack::vision
