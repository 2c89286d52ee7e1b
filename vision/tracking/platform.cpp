#include "vision/tracking/platform.h"

#include <algorithm>
#include <cmath>

#include "vision/following/texture_patch.h"
#include "vision/tracking/notes.h"
#include "vision/tracking/setup.h"

namespace tribotrack::vision {
namespace {

/// What covers the platform at some time: the part along its path, the lamp.
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

/// Averaged over the first frames where its noise matters.
PatternFollower marker_follower(const Picture& first, FrameSource& source, const FrameRange& range,
                                const Circle& circle, double min_ncc, double noise_variance) {
  FollowOptions follow;
  follow.min_ncc = min_ncc;
  follow.noise_variance = noise_variance;
  follow.search_whole_frame = false;
  const Pattern pattern = disc_pattern(first, circle);
  RegistrationOptions registration;
  registration.noise_variance = noise_variance;
  AveragedTemplate average;
  if (TemplateRegistration(first, pattern, registration).template_noise_cost() > kQuietTemplate) {
    average = average_template(source, first, range.first, range.last, pattern, follow);
    follow.template_noise_share = 1.0 / average.frames;
  }
  return {average.picture(first), range.first, pattern, follow};
}

}  // namespace

MarkerSetup set_up_marker(const Picture& first, FrameSource& source, const FrameRange& range,
                          const TrackOptions& options, double noise_variance, const Circle& part) {
  MarkerSetup setup;
  switch (options.marker.kind) {
    case MarkerChoice::Kind::none:
      setup.plan.push_back(no_marker_stage());
      return setup;
    case MarkerChoice::Kind::texture:
      return setup;
    case MarkerChoice::Kind::circle: {
      check_whole(first, options.marker.circle, source, "marker");
      const auto rim = refined(first, options.marker.circle);
      if (!rim) setup.warnings.push_back(no_rim_warning("marker", options.marker.circle));
      setup.circle = rim ? rim->circle : options.marker.circle;
      break;
    }
    case MarkerChoice::Kind::find:
      const auto found = found_marker(first, options, part);
      if (!found) return setup;
      setup.circle = *found;
  }
  setup.plan.push_back(marker_stage(setup.circle));
  setup.follower.emplace(
      marker_follower(first, source, range, setup.circle, options.min_ncc, noise_variance));
  return setup;
}

bool wants_texture(const TrackOptions& options, bool has_marker) {
  using Kind = MarkerChoice::Kind;
  return options.marker.kind == Kind::texture || (options.marker.kind == Kind::find && !has_marker);
}

MarkerPoint marker_point(const Sighting& s) {
  return {s.position.x, s.position.y, std::sqrt(0.5 * s.covariance.trace()), s.ncc};
}

Circle circle_in(const Rect& patch) {
  return {patch.x + 0.5 * (patch.width - 1), patch.y + 0.5 * (patch.height - 1), 0.5 * patch.width};
}

TextureMarker follow_texture(FrameSource& source, const Picture& first, std::int64_t first_index,
                             const TrackOptions& options, double noise_variance, const Pattern& part,
                             Track& track) {
  const int side = std::min(first.width(), first.height());
  TexturePatchSearch search;
  search.noise_variance = noise_variance;
  const double reach =
      part.radius > 0 ? part.radius : 0.5 * std::hypot(part.window.width, part.window.height);
  search.covered = covered_by(track, options, reach);
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
  TextureMarker marker{patch->window, texture_marker_stage(patch->window, patch->limit_px)};
  std::int64_t index = first_index;
  for (TrackPoint& point : track.points) {
    if (const FollowStep step = follower.step(source, index++); step.status == TrackStatus::ok)
      point.marker = marker_point(*step.sighting);
    else
      ++marker.lost;
  }
  track.has_marker = true;
  return marker;
}

}  // namespace tribotrack::vision
