#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <tuple>

#include "vision/kernels/dense.h"
#include "vision/platform_motion/motion.h"
#include "vision/tags/tags.h"
#include "vision/tracking/setup.h"

namespace tribotrack::vision {
namespace {

/// A part as thick as a third of its radius throws its shadow so far where the lamp stands at 45 degrees.
constexpr double kShadow = 1.0 / 3;
constexpr double kRim = 4;  ///< px that the lens's blur may reach

/// The mark found, not the part and not the lamp.
std::optional<Circle> found_marker(const Picture& first, const TrackOptions& options, const Circle& part) {
  DiscSearch search;
  search.min_radius = 3;
  search.keep_out = part;
  search.keep_out->radius = std::max(
      part.radius, 0.5 * std::hypot(options.target.rectangle.width, options.target.rectangle.height));
  auto found = find_discs(first, search, 1 + options.gate.has_value());
  leave_out_lamp(found, options);
  if (found.empty()) return std::nullopt;
  return found.front().circle;
}

/// The tag asked for, and the circle within its black square.
std::pair<SeenTag, Circle> tag_in(const Picture& first, const MarkerChoice& asked,
                                  const FrameSource& source) {
  const std::vector<Tag> all = find_tags(first, asked.dictionary);
  std::string seen;
  for (const Tag& tag : all) seen += fmt::format("{}{}", seen.empty() ? "" : ", ", tag.id);
  const auto refuse = [&](const std::string& what, const std::string& remedy) {
    return InputError(fmt::format("{}: {} in the first analysed frame{}; {}", source.info().path.string(),
                                  what, seen.empty() ? "" : fmt::format(" (numbers seen: {})", seen),
                                  remedy));
  };
  const auto found = asked.id ? std::ranges::find(all, *asked.id, &Tag::id) : all.begin();
  if (found == all.end())
    throw refuse(
        asked.id ? fmt::format("no tag {}:{} is seen", asked.dictionary, *asked.id)
                 : fmt::format("no tag of the family {} is seen", asked.dictionary),
        "it must be whole, with a white margin, and its cells 4 px or larger; another family has another "
        "name");
  if (!asked.id && all.size() > 1)
    throw refuse(fmt::format("{} tags of the family {} are seen", all.size(), asked.dictionary),
                 fmt::format("say which is the mark: {}:{}", asked.dictionary, found->id));
  return {{asked.dictionary, found->id, found->side_px, found->side_sd_px},
          {found->centre.x, found->centre.y, 0.5 * found->side_px}};
}

/// Where the part was seen, and between and beyond that where it was last seen, or is first.
std::vector<Point> path_of(const Track& track, const Point& unseen) {
  std::vector<Point> path;
  std::optional<Point> last;
  for (const TrackPoint& p : track.points) {
    if (p.status == TrackStatus::ok) {
      if (!last) std::ranges::fill(path, Point{p.x, p.y});
      last = {p.x, p.y};
    }
    path.push_back(last.value_or(unseen));
  }
  return path;
}

/// The ground as a mark: the place of it that lay in the picture's middle.
MarkerPoint marker_point(const GroundFix& fix, const Point& middle) {
  MarkerPoint point{middle.x + fix.displacement.x, middle.y + fix.displacement.y,
                    std::sqrt(0.5 * fix.covariance.trace()), fix.score};
  set_covariance(point, fix.covariance);
  return point;
}

}  // namespace

std::optional<PatternFollower> set_up_marker(const Picture& first, FrameSource& source,
                                             const FrameRange& range, const TrackOptions& options,
                                             double noise_variance, const Circle& part,
                                             TrackSummary& summary) {
  Circle& circle = summary.marker;
  switch (options.marker.kind) {
    case MarkerChoice::Kind::none:
      summary.plan.push_back({.name = "marker", .reason = "none given: positions are in the camera's frame"});
      return std::nullopt;
    case MarkerChoice::Kind::automatic:
    case MarkerChoice::Kind::texture:
      return std::nullopt;
    case MarkerChoice::Kind::circle: {
      check_whole(first, options.marker.circle, source, "marker");
      const auto rim = refined(first, options.marker.circle);
      if (!rim) summary.warnings.push_back(no_rim_warning("marker", options.marker.circle));
      circle = rim ? rim->circle : options.marker.circle;
      break;
    }
    case MarkerChoice::Kind::tag:
      std::tie(summary.tag, circle) = tag_in(first, options.marker, source);
      break;
    case MarkerChoice::Kind::find:
      const auto found = found_marker(first, options, part);
      if (!found) return std::nullopt;
      circle = *found;
  }
  summary.plan.push_back(
      {.name = "marker",
       .on = true,
       .reason = fmt::format("at ({:.1f}, {:.1f}) px, radius {:.1f} px: its motion is subtracted", circle.x,
                             circle.y, circle.radius)});
  FollowOptions follow;
  follow.min_ncc = options.min_ncc;
  follow.noise_variance = noise_variance;
  follow.search_whole_frame = false;
  const Pattern pattern = disc_pattern(first, circle);
  const double noise_cost = TemplateRegistration(first, pattern, follow).template_noise_cost();
  const AveragedTemplate average =
      quiet_template(source, first, range.first, range.last, pattern, noise_cost, follow);
  return PatternFollower(average.picture(first), range.first, pattern, follow);
}

std::vector<Circle> over_ground(const Point& part, const Pattern& pattern, const TrackOptions& options) {
  const double reach =
      pattern.radius > 0 ? pattern.radius : 0.5 * std::hypot(pattern.window.width, pattern.window.height);
  std::vector<Circle> over = {{part.x, part.y, (1 + kShadow) * reach + kRim}};
  if (options.gate) over.push_back({options.gate->x, options.gate->y, options.gate->radius + kRim});
  return over;
}

/// Grey levels. A texture of t grey levels rms whose every cell of 8 x 8 px consists of n coefficients has
/// them at 8 t / sqrt(n), and rounding to more than twice that leaves nothing of it: textures have some ten.
/// Along a brush little changes, in many small coefficients that vanish long before.
double coarsest_steps(const GroundVerdict& ground) {
  return (ground.brushed ? 1 : 5) * ground.texture;
}

void follow_platform(FrameSource& source, const FirstPassResult& first, const TrackOptions& options,
                     const Pattern& part, Track& track, TrackSummary& summary) {
  const std::vector<Point> path = path_of(track, part.centre);
  GroundMotionOptions ground;
  ground.noise_variance = first.noise_variance;
  ground.threads = options.threads;
  ground.hidden = [&](std::int64_t index) {
    return over_ground(path[static_cast<std::size_t>(index - first.first_index)], part, options);
  };
  const GroundMotion motion =
      follow_ground(source, first.first_index, first.first_index + first.total - 1, ground);
  const GroundVerdict& verdict = motion.verdict;
  if (!verdict.visible && options.marker.kind != MarkerChoice::Kind::automatic)
    throw InputError(
        source.info().path.string() + ": " +
        (options.marker.kind == MarkerChoice::Kind::find ? "no round marker was found, and " : "") +
        verdict.reason + "; give a marker with --marker X,Y,R or leave it out with --marker none");
  summary.plan.push_back(ground_marker_stage(verdict.reason, verdict.visible ? motion.learnt_from : 0));
  if (!verdict.visible) return;
  const Point middle{0.5 * (source.info().width - 1), 0.5 * (source.info().height - 1)};
  std::int64_t lost = 0;
  for (std::size_t k = 0; k < track.points.size(); ++k)
    if (motion.frames[k])
      track.points[k].marker = marker_point(*motion.frames[k], middle);
    else
      ++lost;
  track.has_marker = true;
  summary.ground_steps = coarsest_steps(verdict);
  if (lost > 0)
    summary.warnings.push_back(fmt::format("the platform's texture was not found again in {} frames", lost));
}

}  // namespace tribotrack::vision
