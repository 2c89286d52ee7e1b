#include "vision/tracking/platform.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "vision/following/texture_patch.h"
#include "vision/tracking/setup.h"

namespace tribotrack::vision {
namespace {

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

}  // namespace

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
  AveragedTemplate average;
  if (TemplateRegistration(first, pattern, probe).template_noise_cost() > kQuietTemplate) {
    average = average_template(source, first, range.first, range.last, pattern, follow);
    follow.template_noise_share = 1.0 / average.frames;
  }
  summary.plan.push_back({"marker", true,
                          fmt::format("at ({:.1f}, {:.1f}) px, radius {:.1f} px: its motion is subtracted",
                                      summary.marker.x, summary.marker.y, summary.marker.radius),
                          0, 0, PlanCosts().marker(summary.marker.radius)});
  return PatternFollower(average.picture(first), range.first, pattern, follow);
}

bool wants_texture(const TrackOptions& options, bool has_marker) {
  using Kind = MarkerChoice::Kind;
  return options.marker.kind == Kind::texture || (options.marker.kind == Kind::find && !has_marker);
}

MarkerPoint marker_point(const Sighting& s) {
  return {s.position.x, s.position.y, std::sqrt(0.5 * s.covariance.trace()), s.ncc};
}

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
       fmt::format(
           "none: a patch of the platform's texture at ({}, {}), {} px wide, that the part never covers "
           "locates it to {:.2g} px a frame",
           patch->window.x, patch->window.y, patch->window.width, patch->limit_px),
       0, 0, PlanCosts().marker(summary.marker.radius)});
  if (const auto lost = static_cast<std::int64_t>(result.track.points.size()) - seen; lost > 0)
    summary.warnings.push_back(fmt::format("the platform's texture was not found again in {} frames", lost));
}

}  // namespace tribotrack::vision
