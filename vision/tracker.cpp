#include "vision/tracker.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "vision/camera/bad_pixels.h"
#include "vision/camera/frame_cache.h"
#include "vision/camera/noise_estimate.h"
#include "vision/discs/mean_radius.h"
#include "vision/layers/keeping.h"
#include "vision/layers/pass.h"
#include "vision/layers/stage.h"
#include "vision/tracking/gate_lamp.h"
#include "vision/tracking/notes.h"
#include "vision/tracking/platform.h"
#include "vision/tracking/setup.h"

namespace tribotrack::vision {
namespace {

constexpr int kNoiseFrames = 6;
constexpr std::int64_t kRimFrames = 16;  ///< in which the disc's radius is measured

FrameRange resolve_range(const FrameSource& source, const TrackOptions& options) {
  const SourceInfo& info = source.info();
  const std::string name = info.path.string();
  if (info.frame_count <= 0) throw InputError(name + " holds no frames");
  const std::int64_t low = info.first_number;
  const std::int64_t high = info.first_number + info.frame_count - 1;
  const std::int64_t first = options.first_frame.value_or(low);
  const std::int64_t last = options.last_frame.value_or(high);
  if (first < low || first > high || last < low || last > high)
    throw InputError(fmt::format("{}: frames {} to {} are asked for, but the recording holds {} to {}", name,
                                 first, last, low, high));
  if (last < first)
    throw InputError(
        fmt::format("{}: the last frame asked for ({}) comes before the first ({})", name, last, first));
  return {first - low, last - low};
}

/// What the first frames tell of the camera.
struct Camera {
  double noise_variance = 0;
  std::vector<Pixel> bad_pixels;
};

/// Few pictures at a time: whole ones are large.
Camera look_at_camera(FrameSource& source, const FrameRange& range) {
  const std::int64_t last = std::min(range.last, range.first + kNoiseFrames - 1);
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

/// The frames that are read several times before the tracking begins.
void keep_leading(KeptFrames& source, const FrameRange& range) {
  constexpr int kFrames = std::max(kNoiseFrames, TemplateAverageOptions{}.frames);
  for (std::int64_t k = range.first; k <= std::min(range.last, range.first + kFrames - 1); ++k)
    source.keep(k, source.bounds());
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
           : fmt::format("{} stand out of their neighbours in all of the first frames: the median of the "
                         "neighbours is seen in their place",
                         camera.bad_pixels.size()),
       0, 0, 0});

  Setup setup = plan_part(first, source, range, options, noise, summary);
  setup.costs.frames = static_cast<double>(range.last - range.first + 1);
  const AveragedTemplate quiet = quiet_template(source, first, range, setup, summary);
  PatternFollower part(quiet.picture(first), range.first, setup.pattern, setup.follow);
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
  if (options.target.kind == Target::Kind::find_disc) note_stillness(result.track, summary);
  note_effort(part.effort(), setup.costs, source.bounds(), summary);
  pass.excess = median_excess(excess);
  pass.layers_cost =
      setup.costs.layers(summary.disc.radius, std::min<double>(kLearningFrames, setup.costs.frames));
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

}  // namespace tribotrack::vision
