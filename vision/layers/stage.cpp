#include "vision/layers/stage.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>

#include "vision/io/levels.h"
#include "vision/kernels/median.h"
#include "vision/layers/pass.h"

namespace tribotrack::vision {
namespace {

constexpr const char* kName = "layers: part over platform";
constexpr double kNegligible = 1;   ///< of the noise: a ground that moves a position by less is not learnt
constexpr double kExplained = 0.1;  ///< of the noise: what may be left where a template explains the part

std::string finding(const FirstPassResult& first) {
  return fmt::format(
      "the ground has a texture of {:.2f} grey levels rms and a single template leaves {:.2f} unexplained, "
      "against noise of {:.2f}",
      first.ground_texture, first.excess, std::sqrt(first.noise_variance));
}

LayeredOutcome left_out(std::string reason) {
  LayeredOutcome outcome;
  outcome.plan.push_back({.name = kName, .reason = std::move(reason)});
  return outcome;
}

/// Px that the rotation by rings looks at, with what its interpolation needs.
double rings_reach(double radius) {
  return 1.5 * radius + 8;
}

/// Px by which a ground of this texture, light on one side of the part and dark on the other, moves its rim.
double pull_of_ground(const FirstPassResult& first) {
  return first.blur * first.ground_texture / first.contrast;
}

/// Neither ground nor part show anything that a single template lacks.
bool nothing_to_learn(const FirstPassResult& first, const Track& track) {
  // Where the part was lost something covered it, which a template does not tell from the part.
  if (std::ranges::any_of(track.points, [](const TrackPoint& p) { return p.status != TrackStatus::ok; }))
    return false;
  const bool by_template = std::ranges::none_of(first.by_rim, std::identity());
  return by_template && first.contrast > 0 && pull_of_ground(first) < kNegligible * first.limit_px &&
         first.excess < kExplained * std::sqrt(first.noise_variance);
}

/// Why the stage is not even tried.
std::optional<PlanStage> reason_against(const FirstPassResult& first, const Track& track, Layers layers) {
  PlanStage stage;
  stage.name = kName;
  if (layers == Layers::off) stage.reason = "switched off; " + finding(first);
  if (first.blur <= 0) stage.reason = "the part has no measured round rim";
  if (layers == Layers::automatic && first.blur > 0 && nothing_to_learn(first, track)) {
    stage.error_bound_px = pull_of_ground(first);
    stage.reason =
        fmt::format("nothing to learn: {}; through the rim the ground moves a position by {:.2g} px at most",
                    finding(first), *stage.error_bound_px);
  }
  if (stage.reason.empty()) return std::nullopt;
  return stage;
}

/// The frames in which the part, and the marker where there is one, were found.
struct SeenFrames {
  std::vector<FirstPassFrame> frames;
  std::vector<std::size_t> places;  ///< in the track
};

SeenFrames seen_frames(const Track& track, const FirstPassResult& first) {
  SeenFrames seen;
  const MarkerPoint* origin = nullptr;
  for (std::size_t k = 0; k < track.points.size(); ++k) {
    const TrackPoint& p = track.points[k];
    if (p.status != TrackStatus::ok || (track.has_marker && !p.marker)) continue;
    FirstPassFrame f;
    f.index = first.first_index + static_cast<std::int64_t>(k);
    f.centre = {p.x, p.y};
    if (p.marker) {
      if (!origin) origin = &*p.marker;
      f.ground = {p.marker->x - origin->x, p.marker->y - origin->y};
    }
    seen.frames.push_back(f);
    seen.places.push_back(k);
  }
  return seen;
}

LayeredOptions options_of(const FirstPassResult& first, const TrackOptions& options,
                          const std::vector<ShownFrame>& shown) {
  LayeredOptions out;
  out.disc = first.disc;
  out.blur = first.blur;
  out.noise_variance = first.noise_variance;
  out.first_index = first.first_index;
  out.total = first.total;
  if (options.progress)
    out.progress = [&progress = options.progress, total = first.total](std::int64_t done) {
      progress((total + done) / 2, total);
    };
  out.threads = options.threads;
  out.debug = options.debug;
  out.shown = shown;
  return out;
}

void change(TrackPoint& point, const LayeredFix& fix) {
  point.x = fix.state.centre.x;
  point.y = fix.state.centre.y;
  point.sigma_x = std::sqrt(fix.covariance(0, 0));
  point.sigma_y = std::sqrt(fix.covariance(1, 1));
  point.rho_xy = fix.covariance(0, 1) / (point.sigma_x * point.sigma_y);
  point.ncc = fix.ncc;
}

/// How the second pass changed a track.
struct Change {
  std::int64_t measured = 0;  ///< frames
  std::int64_t kept = 0;      ///< frames that keep the first pass's position
  double median_sd = 0;       ///< of a coordinate of the measured ones, px
  double moved = 0;           ///< px rms, without the mean
};

Change replace_positions(Track& track, const std::vector<std::size_t>& places,
                         const std::vector<std::optional<LayeredFix>>& fixes) {
  std::vector<bool> changed(track.points.size(), false);
  std::vector<double> sds;
  Point moved;
  double square = 0;
  for (std::size_t k = 0; k < places.size(); ++k) {
    if (!fixes[k]) continue;
    TrackPoint& p = track.points[places[k]];
    const double x = fixes[k]->state.centre.x - p.x, y = fixes[k]->state.centre.y - p.y;
    square += std::pow(x, 2) + std::pow(y, 2);
    moved.x += x;
    moved.y += y;
    change(p, *fixes[k]);
    changed[places[k]] = true;
    sds.push_back(std::sqrt(0.5 * fixes[k]->covariance.trace()));
  }
  Change out;
  if (sds.empty()) return out;
  const auto count = static_cast<double>(sds.size());
  // The rest moves with the mean, so that both passes refer to the same point of the disc.
  for (std::size_t k = 0; k < track.points.size(); ++k)
    if (track.points[k].status == TrackStatus::ok && !changed[k]) {
      track.points[k].x += moved.x / count;
      track.points[k].y += moved.y / count;
      ++out.kept;
    }
  out.measured = static_cast<std::int64_t>(sds.size());
  out.moved =
      std::sqrt(std::max(0.0, (square - (moved.x * moved.x + moved.y * moved.y) / count) / (2 * count)));
  out.median_sd = median(sds);
  return out;
}

/// Of errors that so many frames share, s.
double correlation_time(double frames, const Track& track) {
  const double duration = track.points.back().time_s - track.points.front().time_s;
  return frames * duration / std::max<double>(1, static_cast<double>(track.points.size()) - 1);
}

PlanStage layers_stage(const LayeredResult& result, const FirstPassResult& first, double moved) {
  std::string reason =
      finding(first) + fmt::format("; learnt from {} frames in {} rounds", result.windows, result.rounds);
  if (result.crossed_share > 0)
    reason += fmt::format("; {:.2g} % of the ground beside it was crossed by something, which is left out",
                          100 * result.crossed_share);
  reason += "; noise from frame to frame: " + result.noise;
  reason += fmt::format("; positions moved by {:.4f} px rms", moved);
  // Of what the frames tell at a place its share of the ground and the ground there take one frame's each.
  reason += fmt::format(
      "; what frames share through the noise of the pictures, some {:.1f} % of a position's variance, is not "
      "counted between them",
      200.0 / std::max(1, result.windows));
  return {.name = kName, .on = true, .reason = std::move(reason), .error_bound_px = moved};
}

std::string kept_warning(std::int64_t frames) {
  return fmt::format(
      "{} frames keep the position of the first pass, in which the ground is seen through the rim (the "
      "ground "
      "about the part is not known there, or something covers it): their standard deviations are wider",
      frames);
}

}  // namespace

bool layers_wanted(const FirstPassResult& first, Layers layers) {
  return layers != Layers::off && first.blur > 0;
}

LayeredOutcome layered_stage(FrameSource& source, const FirstPassResult& first, const TrackOptions& options,
                             const std::vector<ShownFrame>& shown, StageClock& clock, Track& track) {
  if (auto reason = reason_against(first, track, options.layers)) {
    LayeredOutcome outcome;
    outcome.plan.push_back(std::move(*reason));
    return outcome;
  }
  const SeenFrames seen = seen_frames(track, first);
  const LayeredResult result = layered_pass(source, seen.frames, options_of(first, options, shown), clock);
  if (result.fixes.empty()) return left_out(result.why_not + "; " + finding(first));
  const Change change = replace_positions(track, seen.places, result.fixes);
  if (change.measured == 0) return left_out("the layers explain no frame; " + finding(first));

  LayeredOutcome outcome;
  outcome.done = true;
  outcome.limit_px = change.median_sd;
  outcome.ground_known = result.ground_known;
  outcome.slow_sd = result.slow_sd;
  outcome.audited = result.audited;
  outcome.slow_time = correlation_time(result.slow_frames, track);
  outcome.disc_radius = result.disc_radius;
  outcome.disc_radius_sd = result.disc_radius_sd;
  outcome.plan = {layers_stage(result, first, change.moved)};
  if (change.kept > 0) outcome.warnings.push_back(kept_warning(change.kept));
  return outcome;
}

FramesReadAgain::FramesReadAgain(KeptFrames& frames, const FirstPassResult& first, Layers layers)
    : frames_(frames),
      first_index_(first.first_index),
      total_(first.total),
      layers_(layers_wanted(first, layers)),
      reach_(first.texture_seen ? rings_reach(first.disc.radius) : 0) {
  if (layers_) reach_ = layered_reach(first.disc.radius, first.blur);
}

void FramesReadAgain::seen(std::int64_t index, const Point& centre) {
  if (!(reach_ > 0)) return;
  const bool whole = layers_ && is_learning_frame(index - first_index_, total_);
  // A later pass may round the centre otherwise.
  frames_.keep(index, whole ? frames_.bounds() : window_about(centre, reach_ + 1, frames_.bounds()));
}

}  // namespace tribotrack::vision
