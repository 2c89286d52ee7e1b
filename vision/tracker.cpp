#include "vision/tracker.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "vision/arrival.h"
#include "vision/bad_pixels.h"
#include "vision/disc_detection.h"
#include "vision/gate_lamp.h"
#include "vision/kept_frames.h"
#include "vision/layered_keeping.h"
#include "vision/layered_stage.h"
#include "vision/noise_estimate.h"
#include "vision/pattern_follower.h"
#include "vision/plan_costs.h"
#include "vision/rim_watch.h"
#include "vision/template_average.h"
#include "vision/texture_patch.h"
#include "vision/texture_proof.h"

namespace tribotrack::vision {
namespace {

constexpr int kNoiseFrames = 6;
constexpr double kGivenCapture = 3;       ///< px a user's click may be wrong
constexpr std::int64_t kRimFrames = 16;   ///< in which the disc's radius is measured
constexpr double kClickSd = 0.5;          ///< sd of a radius that no rim confirms, px
constexpr double kRotationLimit = 0.05;   ///< rad: a texture that shows less does not show rotation
constexpr double kQuietTemplate = 0.002;  ///< added variance that is not worth averaging frames for
constexpr double kTextureFactor = 2;  ///< platform texture above this multiple of the noise narrows the mask

template <typename... Args>
std::string format(const char* pattern, Args... args) {
  std::array<char, 512> text{};
  std::snprintf(text.data(), text.size(), pattern, args...);
  return text.data();
}

struct FrameRange {
  std::int64_t first = 0, last = 0;  ///< indices, both included
};

FrameRange resolve_range(const FrameSource& source, const TrackOptions& options) {
  const SourceInfo& info = source.info();
  const std::string name = info.path.string();
  if (info.frame_count <= 0) throw InputError(name + " holds no frames");
  const std::int64_t low = info.first_number;
  const std::int64_t high = info.first_number + info.frame_count - 1;
  const std::int64_t first = options.first_frame.value_or(low);
  const std::int64_t last = options.last_frame.value_or(high);
  if (first < low || first > high || last < low || last > high)
    throw InputError(format("%s: frames %lld to %lld are asked for, but the recording holds %lld to %lld",
                            name.c_str(), static_cast<long long>(first), static_cast<long long>(last),
                            static_cast<long long>(low), static_cast<long long>(high)));
  if (last < first)
    throw InputError(format("%s: the last frame asked for (%lld) comes before the first (%lld)", name.c_str(),
                            static_cast<long long>(last), static_cast<long long>(first)));
  return {first - low, last - low};
}

/// What the first frames tell of the camera.
struct Camera {
  double noise_variance = 0;
  std::vector<Pixel> bad_pixels;
};

Camera look_at_camera(FrameSource& source, const FrameRange& range) {
  std::vector<Picture> frames;
  NoiseEstimate estimate;
  for (std::int64_t k = range.first; k <= std::min(range.last, range.first + kNoiseFrames - 1); ++k) {
    frames.push_back(source.read(k));
    if (k > range.first) estimate.add_pair(frames[frames.size() - 2], frames.back());
  }
  const double variance = estimate.variance(frames.front());
  return {variance, find_bad_pixels(frames, variance)};
}

/// The frames that are read several times before the tracking begins.
void keep_leading(KeptFrames& source, const FrameRange& range) {
  constexpr int kFrames = std::max(kNoiseFrames, TemplateAverageOptions{}.frames);
  for (std::int64_t k = range.first; k <= std::min(range.last, range.first + kFrames - 1); ++k)
    source.keep(k, source.bounds());
}

bool whole_in(const Rect& picture, const Circle& c) {
  return c.x - c.radius >= -0.5 && c.y - c.radius >= -0.5 && c.x + c.radius <= picture.width - 0.5 &&
         c.y + c.radius <= picture.height - 0.5;
}

Rect all_of(const Picture& picture) {
  return {0, 0, picture.width(), picture.height()};
}

double capture_of(const Circle& given) {
  return std::max(kGivenCapture, 0.03 * given.radius);
}

/// A click made exact by the rim where it supports it; nothing, and a warning, where it does not.
std::optional<DiscFit> refined(const Picture& first, const Circle& given, const char* what,
                               TrackSummary& summary) {
  if (auto fit = fit_disc(first, given, capture_of(given)); fit && whole_in(all_of(first), fit->circle))
    return fit;
  summary.warnings.push_back(format(
      "the %s's rim near (%.1f, %.1f) px is not seen as a circle: its given centre and radius are used "
      "as they are, and a scale from its diameter is as good as the given radius",
      what, given.x, given.y));
  return std::nullopt;
}

void check_whole(const Picture& first, const Circle& c, const FrameSource& source, const char* what) {
  if (whole_in(all_of(first), c) && c.radius >= 2) return;
  throw InputError(
      format("%s: the %s at (%.1f, %.1f) px with radius %.1f px is not wholly in the %d x %d "
             "picture; give its place in the first analysed frame, or start at a frame in which "
             "it is whole",
             source.info().path.string().c_str(), what, c.x, c.y, c.radius, first.width(), first.height()));
}

/// Texture of the ground around the disc, grey levels rms beyond noise: what a wider mask would let in. What
/// lies far outside the median deviation, a neighbour or a shadow, does not count.
double ground_texture(const Picture& first, const Circle& disc, double noise_variance) {
  std::vector<float> levels;
  const double inner = disc.radius + 4;
  const double outer = disc.radius + std::max(8.0, 0.25 * disc.radius);
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

/// The lamp is round and bright, too.
void leave_out_lamp(std::vector<DiscFit>& found, const TrackOptions& options) {
  if (!options.gate) return;
  std::erase_if(found, [&](const DiscFit& f) {
    return std::hypot(f.circle.x - options.gate->x, f.circle.y - options.gate->y) <
           std::max(options.gate->radius, f.circle.radius);
  });
}

DiscSearch search_for_part(const TrackOptions& options) {
  DiscSearch search;
  if (options.marker.kind == MarkerChoice::Kind::circle) {
    search.keep_out = options.marker.circle;
    search.keep_out->radius += capture_of(*search.keep_out);
  }
  return search;
}

/// Where the recording starts before the part is there: the frame it is first seen in. Range.first where it
/// is not seen at all, or need not be a disc.
std::int64_t arrival(FrameSource& source, const FrameRange& range, const TrackOptions& options) {
  const std::int64_t first = range.first;
  switch (options.target.kind) {
    case Target::Kind::rectangle:
      break;
    case Target::Kind::disc:
      if (!whole_in(source.bounds(), options.target.disc)) break;
      return arrival_at(source, first, range.last, options.target.disc, capture_of(options.target.disc))
          .value_or(first);
    case Target::Kind::find_disc:
      // A marker or a lamp left to be found is round, too: then the first frame must hold the part.
      if (options.marker.kind != MarkerChoice::Kind::find && !options.gate)
        return arrival_anywhere(source, first, range.last, search_for_part(options)).value_or(first);
  }
  return first;
}

/// The part, where the user does not say where it is: away from a given marker, which is round too, and the
/// largest of what is supported nearly as well as the best.
DiscFit find_part(const Picture& first, const FrameSource& source, const TrackOptions& options) {
  const DiscSearch search = search_for_part(options);
  auto found = find_discs(first, search, 5);
  leave_out_lamp(found, options);
  if (found.empty())
    throw InputError(source.info().path.string() +
                     ": no disc was found in the first analysed frame; give it with --disc X,Y,R");
  DiscFit best = found.front();
  if (search.keep_out)
    for (const DiscFit& other : found)
      if (other.score > 0.5 * found.front().score && other.circle.radius > best.circle.radius) best = other;
  return best;
}

struct Setup {
  Pattern pattern;
  std::optional<DiscFit> rim;  ///< in the first frame
  FollowOptions follow;
  double ground_texture = 0;
  double template_noise_cost = 0;
  PlanCosts costs;
};

/// Pixels of the template, those that take part, and the window that is read about a prediction.
PlanCosts costs_of(const Pattern& pattern, const TemplateRegistration& registration) {
  constexpr int kMargin = 10;
  PlanCosts costs;
  for (const float weight : pattern.weights.levels()) costs.mask_pixels += weight > 0;
  costs.part_pixels = costs.mask_pixels * registration.pixel_share();
  costs.window_pixels = (pattern.window.width + kMargin) * (pattern.window.height + kMargin);
  return costs;
}

Setup plan_part(const Picture& first, FrameSource& source, const FrameRange& range,
                const TrackOptions& options, double noise_variance, TrackSummary& summary) {
  Setup setup;
  setup.follow.min_ncc = options.min_ncc;
  setup.follow.noise_variance = noise_variance;
  setup.follow.search_margin_px = options.search_margin_px;
  if (options.target.kind == Target::Kind::rectangle) {
    const Rect& r = options.target.rectangle;
    if (r.width < 8 || r.height < 8 || !source.bounds().contains(r))
      throw InputError(format(
          "%s: the template %d,%d,%d,%d must be at least 8 x 8 px and lie inside the %d x %d "
          "picture",
          source.info().path.string().c_str(), r.x, r.y, r.width, r.height, first.width(), first.height()));
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
    const double texture = ground_texture(first, summary.disc, noise_variance);
    setup.ground_texture = texture;
    const bool busy = texture > kTextureFactor * std::sqrt(noise_variance);
    DiscPatternOptions mask;
    mask.margin_px = busy ? 0 : 3;
    setup.pattern = disc_pattern(first, summary.disc, mask);
    summary.plan.push_back({"mask beyond the rim", !busy,
                            format("the ground around the disc has a texture of %.1f grey levels rms against "
                                   "noise of %.1f",
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
           ? format("the part's texture shows its rotation to %.3g rad", trial.limit_theta())
           : std::string("the part has no texture above the noise that shows rotation"),
       0, 0, setup.costs.rotation()});
  return setup;
}

/// The template the part is followed with: averaged over the first frames where its noise matters.
AveragedTemplate quiet_template(FrameSource& source, const Picture& first, const FrameRange& range,
                                Setup& setup, TrackSummary& summary) {
  const double cost = 100 * setup.template_noise_cost;
  AveragedTemplate average;
  std::string reason;
  if (setup.follow.rotation) {
    reason = "the part may turn: frames are not laid on each other";
  } else if (setup.template_noise_cost < kQuietTemplate) {
    reason = format("the noise of a single template adds %.2g %% to the variance", cost);
  } else {
    average = average_template(source, first, range.first, range.last, setup.pattern, setup.follow);
    setup.follow.template_noise_share = 1.0 / average.frames;
    reason = format("the noise of a single template adds %.2g %% to the variance; %d frames agree", cost,
                    average.frames);
  }
  if (average.picture.empty()) average.picture = first;
  summary.plan.push_back({"template averaged over the first frames", average.frames > 1, reason, 0,
                          summary.limit_px * (std::sqrt(1 + setup.template_noise_cost) - 1),
                          setup.costs.averaging(TemplateAverageOptions{}.frames)});
  return average;
}

std::optional<PatternFollower> plan_marker(const Picture& first, const FrameRange& range, FrameSource& source,
                                           const TrackOptions& options, double noise_variance,
                                           TrackSummary& summary) {
  if (options.marker.kind == MarkerChoice::Kind::none) {
    constexpr double kUsualRadius = 12;
    summary.plan.push_back({"marker", false, "none asked for: positions are the camera's", 0, 0,
                            PlanCosts().marker(kUsualRadius)});
    return std::nullopt;
  }
  if (options.marker.kind == MarkerChoice::Kind::texture) return std::nullopt;  // once the path is known
  if (options.marker.kind == MarkerChoice::Kind::circle) {
    check_whole(first, options.marker.circle, source, "marker");
    const auto rim = refined(first, options.marker.circle, "marker", summary);
    summary.marker = rim ? rim->circle : options.marker.circle;
  } else {
    DiscSearch search;
    search.min_radius = 3;
    search.keep_out = summary.disc;
    search.keep_out->radius =
        std::max(summary.disc.radius,
                 0.5 * std::hypot(options.target.rectangle.width, options.target.rectangle.height));
    auto found = find_discs(first, search, 1 + options.gate.has_value());
    leave_out_lamp(found, options);
    if (found.empty()) return std::nullopt;  // the texture's turn
    summary.marker = found.front().circle;
  }
  FollowOptions follow;
  follow.min_ncc = options.min_ncc;
  follow.noise_variance = noise_variance;
  follow.search_whole_frame = false;
  const Pattern pattern = disc_pattern(first, summary.marker);
  RegistrationOptions probe;
  probe.noise_variance = noise_variance;
  AveragedTemplate average{first, 1};
  if (TemplateRegistration(first, pattern, probe).template_noise_cost() > kQuietTemplate) {
    average = average_template(source, first, range.first, range.last, pattern, follow);
    follow.template_noise_share = 1.0 / average.frames;
  }
  summary.plan.push_back({"marker", true,
                          format("at (%.1f, %.1f) px, radius %.1f px: its motion is subtracted",
                                 summary.marker.x, summary.marker.y, summary.marker.radius),
                          0, 0, PlanCosts().marker(summary.marker.radius)});
  return PatternFollower(average.picture, range.first, pattern, follow);
}

bool wants_texture(const TrackOptions& options, bool has_marker) {
  using Kind = MarkerChoice::Kind;
  return options.marker.kind == Kind::texture || (options.marker.kind == Kind::find && !has_marker);
}

/// What hides the platform at some time: the part along its path, the lamp.
std::vector<Circle> covered_by(const Track& track, const TrackOptions& options, double part_radius) {
  std::vector<Circle> covered;
  for (const TrackPoint& p : track.points) {
    if (p.status != TrackStatus::ok) continue;
    const Circle here{p.x, p.y, part_radius + 6};
    if (covered.empty() || std::hypot(here.x - covered.back().x, here.y - covered.back().y) > 2)
      covered.push_back(here);
  }
  if (options.gate) covered.push_back({options.gate->x, options.gate->y, options.gate->radius + 6});
  return covered;
}

MarkerPoint marker_point(const Sighting& s);

/// The platform followed by a patch of its own texture, in a pass of its own: only now the part's path is
/// known.
void follow_texture(FrameSource& source, const Picture& first, std::int64_t first_index,
                    const TrackOptions& options, double noise_variance, const Pattern& part,
                    TrackResult& result) {
  const int side = std::min(first.width(), first.height());
  TexturePatchSearch search;
  search.noise_variance = noise_variance;
  const double reach =
      part.radius > 0 ? part.radius : 0.5 * std::hypot(part.window.width, part.window.height);
  search.covered = covered_by(result.track, options, reach);
  search.margin_px = std::clamp(side / 20, 8, 40);
  std::string why_not;
  const auto patch = best_texture_patch(first, search, why_not);
  if (!patch)
    throw InputError(
        source.info().path.string() + ": " +
        (options.marker.kind == MarkerChoice::Kind::find ? "no round marker was found, and " : "") + why_not +
        "; give a marker with --marker X,Y,R or leave it out with --marker none");
  FollowOptions follow;
  follow.min_ncc = std::min(options.min_ncc, 0.5);
  follow.noise_variance = noise_variance;
  follow.search_whole_frame = false;
  PatternFollower follower(first, first_index, rectangle_pattern(patch->window), follow);
  std::int64_t index = first_index, seen = 0;
  for (TrackPoint& point : result.track.points) {
    if (const FollowStep step = follower.step(source, index++); step.status == TrackStatus::ok) {
      point.marker = marker_point(*step.sighting);
      ++seen;
    }
  }
  TrackSummary& summary = result.summary;
  result.track.has_marker = true;
  summary.texture_patch = patch->window;
  summary.marker = {patch->window.x + 0.5 * (patch->window.width - 1),
                    patch->window.y + 0.5 * (patch->window.height - 1), 0.5 * patch->window.width};
  summary.plan.push_back(
      {"marker", true,
       format("none: a patch of the platform's texture at (%d, %d), %d px wide, that the part never covers "
              "locates it to %.2g px a frame",
              patch->window.x, patch->window.y, patch->window.width, patch->limit_px),
       0, 0, PlanCosts().marker(summary.marker.radius)});
  if (const auto lost = static_cast<std::int64_t>(result.track.points.size()) - seen; lost > 0)
    summary.warnings.push_back(
        format("the platform's texture was not found again in %lld frames", static_cast<long long>(lost)));
}

void fill(TrackPoint& point, const Sighting& s) {
  point.status = TrackStatus::ok;
  point.x = s.position.x;
  point.y = s.position.y;
  point.sigma_x = std::sqrt(s.covariance(0, 0));
  point.sigma_y = std::sqrt(s.covariance(1, 1));
  point.rho_xy = s.covariance(0, 1) / (point.sigma_x * point.sigma_y);
  point.ncc = s.ncc;
}

MarkerPoint marker_point(const Sighting& s) {
  return {s.position.x, s.position.y, std::sqrt(0.5 * s.covariance.trace()), s.ncc};
}

void count(const Track& track, double max_lost_share, TrackSummary& summary) {
  const auto& points = track.points;
  summary.frames = static_cast<std::int64_t>(points.size());
  for (const TrackPoint& p : points) {
    summary.ok += p.status == TrackStatus::ok;
    summary.lost += p.status == TrackStatus::lost;
    summary.edge += p.status == TrackStatus::edge;
  }
  // Left for good: not seen again after an edge.
  std::size_t end = points.size();
  while (end > 0 && points[end - 1].status != TrackStatus::ok) --end;
  summary.left_for_good = end < points.size() && points[end].status == TrackStatus::edge;
  const std::size_t counted = summary.left_for_good ? end : points.size();
  for (std::size_t k = 0; k < counted; ++k) summary.lost_counted += points[k].status == TrackStatus::lost;
  summary.gate_passed = static_cast<double>(summary.lost_counted) <=
                        max_lost_share * static_cast<double>(std::max<std::int64_t>(1, summary.frames));
}

void note_effort(const FollowEffort& effort, const PlanCosts& costs, const Rect& picture,
                 TrackSummary& summary) {
  const auto frames = static_cast<double>(std::max<std::int64_t>(1, summary.frames));
  // A stage that is on works in some of the frames; one that is off would have worked in all.
  const auto share = [&](std::int64_t used) { return used > 0 ? static_cast<double>(used) / frames : 1; };
  constexpr double kMargin = 5;
  summary.plan.push_back({"correlation over the predicted window", effort.window_searches > 0,
                          format("refinement from the prediction proved the match in %.1f %% of the frames",
                                 100 * static_cast<double>(effort.proved_by_refinement) / frames),
                          0, 0, share(effort.window_searches) * costs.window_search(kMargin)});
  summary.plan.push_back({"search of the whole frame", effort.whole_frame_searches > 0,
                          format("needed in %lld frames, where the part was lost",
                                 static_cast<long long>(effort.whole_frame_searches)),
                          0, 0, share(effort.whole_frame_searches) * costs.whole_search(picture)});
}

/// Grey levels rms beyond the noise, of the median frame.
double median_excess(std::vector<double>& excess) {
  if (excess.empty()) return 0;
  const auto middle = excess.begin() + static_cast<std::ptrdiff_t>(excess.size() / 2);
  std::nth_element(excess.begin(), middle, excess.end());
  return *middle;
}

void note_excess(double excess, double noise, TrackSummary& summary) {
  if (excess > 0.5 * noise)
    summary.warnings.push_back(format(
        "the registration leaves %.2f grey levels rms beyond the noise of %.2f (moving ground seen through "
        "the rim, glare, compression): the standard deviations are widened accordingly",
        excess, noise));
}

}  // namespace

void TrackOptions::validate() const {
  if (!(min_ncc > 0 && min_ncc < 1)) throw std::invalid_argument("min_ncc must lie between 0 and 1");
  if (!(max_lost_share >= 0 && max_lost_share <= 1))
    throw std::invalid_argument("max_lost_share must lie between 0 and 1");
  if (search_margin_px < 0) throw std::invalid_argument("search_margin_px must not be negative");
  const auto check = [](const Circle& c, const char* what) {
    if (!(std::isfinite(c.x) && std::isfinite(c.y) && std::isfinite(c.radius) && c.radius > 0))
      throw std::invalid_argument(std::string(what) + " must have finite coordinates and a positive radius");
  };
  if (gate) check(*gate, "gate");
  if (target.kind == Target::Kind::disc) check(target.disc, "target.disc");
  if (marker.kind == MarkerChoice::Kind::circle) check(marker.circle, "marker.circle");
}

namespace {

/// Frames before the part was there: they say so, and no gate counts them.
void prepend_absence(const FrameSource& source, const FrameRange& range, TrackResult& result) {
  std::vector<TrackPoint> before;
  for (std::int64_t index = range.first; index <= range.last; ++index) {
    TrackPoint& point = before.emplace_back();
    point.frame = source.number(index);
    point.time_s = source.time_s(index);
    point.status = TrackStatus::lost;
  }
  auto& points = result.track.points;
  points.insert(points.begin(), before.begin(), before.end());
  const auto absent = static_cast<std::int64_t>(before.size());
  result.summary.frames += absent;
  result.summary.lost += absent;
  result.summary.absent_at_first = absent;
}

/// Follows the part from a frame in which it is there. `kept` is what `source` reads from.
TrackResult follow(FrameSource& source, KeptFrames& kept, const FrameRange& range, const Camera& camera,
                   const TrackOptions& options) {
  keep_leading(kept, range);
  TrackResult result;
  TrackSummary& summary = result.summary;

  const Picture first = source.read(range.first);
  const double noise = camera.noise_variance;
  summary.noise_levels = std::sqrt(noise);
  summary.plan.push_back(
      {"bad pixels", !camera.bad_pixels.empty(),
       camera.bad_pixels.empty()
           ? std::string("no pixel stands out of its neighbours in all of the first frames")
           : format("%zu stand out of their neighbours in all of the first frames: the median of the "
                    "neighbours is seen in their place",
                    camera.bad_pixels.size()),
       0, 0, 0});

  Setup setup = plan_part(first, source, range, options, noise, summary);
  setup.costs.frames = static_cast<double>(range.last - range.first + 1);
  const AveragedTemplate quiet = quiet_template(source, first, range, setup, summary);
  PatternFollower part(quiet.picture, range.first, setup.pattern, setup.follow);
  std::optional<PatternFollower> marker = plan_marker(first, range, source, options, noise, summary);
  result.track.has_marker = marker.has_value();
  std::optional<GateLamp> lamp;
  if (options.gate) lamp.emplace(*options.gate, source);
  result.track.has_gate = lamp.has_value();
  summary.gate_pixels = lamp ? lamp->pixels() : 0;

  FirstPass pass;
  pass.first_index = range.first;
  pass.turning = setup.follow.rotation;
  pass.noise_variance = noise;
  pass.ground_texture = setup.ground_texture;
  if (setup.pattern.radius > 0 && !setup.rim) setup.rim = fit_disc(first, summary.disc, 1);
  if (setup.rim) pass.blur = setup.rim->blur;
  pass.total = range.last - range.first + 1;
  std::optional<LayeredKeeping> keeping;
  if (options.layers != Layers::off && pass.blur > 0)
    keeping.emplace(kept, range.first, pass.total, summary.disc.radius, pass.blur,
                    layers_wanted(pass, summary.disc.radius, options.layers));
  std::vector<double> excess;
  std::optional<Sighting> tentative;
  auto& points = result.track.points;
  const std::int64_t total = pass.total;
  points.reserve(static_cast<std::size_t>(total));
  RimWatch rim(summary.disc, total / kRimFrames, setup.rim);
  for (std::int64_t index = range.first; index <= range.last; ++index) {
    TrackPoint point;
    point.frame = source.number(index);
    point.time_s = source.time_s(index);
    const FollowStep step = part.step(source, index);
    if (step.confirms_previous && tentative) {
      fill(points.back(), *tentative);
      pass.theta.back() = tentative->pose.theta;
      ++summary.refound;
    }
    tentative = step.tentative ? step.sighting : std::nullopt;
    point.status = step.status;
    if (step.status == TrackStatus::ok) {
      fill(point, *step.sighting);
      excess.push_back(step.sighting->excess_rms);
      if (setup.pattern.radius > 0) rim.see(source, index, step.sighting->position);
    }
    if (marker)
      if (const FollowStep seen = marker->step(source, index); seen.status == TrackStatus::ok)
        point.marker = marker_point(*seen.sighting);
    if (lamp) {
      const GateLamp::Sample light = lamp->sample(source, index);
      point.gate = light.level;
      summary.gate_clipped_share = std::max(summary.gate_clipped_share, light.clipped_share);
    }
    if (keeping && step.sighting) keeping->seen(index, step.sighting->position);
    points.push_back(point);
    pass.theta.push_back(step.status == TrackStatus::ok ? step.sighting->pose.theta : 0);
    if (options.progress) options.progress(index - range.first + 1, total);
  }
  if (wants_texture(options, marker.has_value()))
    follow_texture(source, first, range.first, options, noise, setup.pattern, result);
  count(result.track, options.max_lost_share, summary);
  note_effort(part.effort(), setup.costs, source.bounds(), summary);
  pass.excess = median_excess(excess);
  pass.layers_cost = setup.costs.layers(summary.disc.radius, std::min(128.0, setup.costs.frames));
  summary.layered =
      layered_stage(source, pass, options.layers, result.track, summary, [&](std::int64_t done) {
        if (options.progress) options.progress(total + done, 2 * total);
      });
  if (const auto mean = rim.radius(); mean && summary.disc_radius_sd < kClickSd) {
    summary.disc.radius = mean->radius;
    summary.disc_radius_sd = mean->sd;
    summary.disc_radius_common_sd = mean->common_sd;
  }
  if (!summary.layered) note_excess(pass.excess, summary.noise_levels, summary);
  predict_savings(summary.plan, setup.costs.base());
  return result;
}

}  // namespace

TrackResult track(FrameSource& recording, const TrackOptions& options) {
  options.validate();
  if (!recording.info().time_base.known()) throw InputError(recording.info().time_base.why_unknown());
  const FrameRange range = resolve_range(recording, options);
  KeptFrames kept(recording);
  keep_leading(kept, range);
  const Camera camera = look_at_camera(kept, range);
  std::optional<MendedSource> mended;
  if (!camera.bad_pixels.empty()) mended.emplace(kept, camera.bad_pixels);
  FrameSource& frames = mended ? static_cast<FrameSource&>(*mended) : kept;
  const std::int64_t start = arrival(frames, range, options);
  TrackResult result = follow(frames, kept, {start, range.last}, camera, options);
  if (start > range.first) prepend_absence(frames, {range.first, start - 1}, result);
  return result;
}

std::string TrackSummary::brief_report() const {
  std::string text =
      format("%lld frames: %lld ok, %lld lost, %lld edge", static_cast<long long>(frames),
             static_cast<long long>(ok), static_cast<long long>(lost), static_cast<long long>(edge));
  if (refound > 0) text += format(", found again %lld times", static_cast<long long>(refound));
  if (absent_at_first > 0)
    text += format(", not there in the first %lld", static_cast<long long>(absent_at_first));
  if (left_for_good) text += ", left the picture for good";
  text += format("; noise %.2f grey levels, limit %.4f px", noise_levels, limit_px);
  if (disc.radius > 0) text += format("; disc at (%.2f, %.2f), radius %.3f px", disc.x, disc.y, disc.radius);
  if (!gate_passed) text += "; GATE FAILED: lost for more than the allowed share of frames";
  return text;
}

}  // namespace tribotrack::vision
