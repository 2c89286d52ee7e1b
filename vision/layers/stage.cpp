#include "vision/layers/stage.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "vision/layers/pass.h"

namespace tribotrack::vision {
namespace {

constexpr double kTextureShare = 0.3;  ///< of the noise: the least ground texture that costs accuracy
constexpr double kScatter = 4;         ///< sd of a variance's estimate that are not a texture
constexpr double kExcessShare = 0.3;   ///< of the noise: the single template leaves something unexplained
constexpr const char* kName = "layers: disc over platform";

std::string finding(const FirstPass& first) {
  return fmt::format(
      "the ground has a texture of {:.2f} grey levels rms and a single template leaves {:.2f} "
      "unexplained, against noise of {:.2f}",
      first.ground_texture, first.excess, std::sqrt(first.noise_variance));
}

/// The frames in which the part, and the marker where there is one, were found.
std::vector<FirstPassFrame> seen_frames(const Track& track, const FirstPass& first,
                                        std::vector<std::size_t>& places) {
  std::vector<FirstPassFrame> frames;
  const MarkerPoint* origin = nullptr;
  for (std::size_t k = 0; k < track.points.size(); ++k) {
    const TrackPoint& p = track.points[k];
    if (p.status != TrackStatus::ok || (track.has_marker && !p.marker)) continue;
    FirstPassFrame f;
    f.index = first.first_index + static_cast<std::int64_t>(k);
    f.centre = {p.x, p.y};
    f.theta = first.theta[k];
    if (p.marker) {
      if (!origin) origin = &*p.marker;
      f.ground = {p.marker->x - origin->x, p.marker->y - origin->y};
    }
    frames.push_back(f);
    places.push_back(k);
  }
  return frames;
}

void change(TrackPoint& point, const LayeredFix& fix) {
  point.x = fix.state.centre.x;
  point.y = fix.state.centre.y;
  point.sigma_x = std::sqrt(fix.covariance(0, 0));
  point.sigma_y = std::sqrt(fix.covariance(1, 1));
  point.rho_xy = fix.covariance(0, 1) / (point.sigma_x * point.sigma_y);
  point.ncc = fix.ncc;
}

/// What is left to the first pass gets the mean difference of the two passes, so that both speak of the same
/// point of the disc.
void keep_the_rest(Track& track, const std::vector<bool>& changed, const Point& moved) {
  for (std::size_t k = 0; k < track.points.size(); ++k)
    if (track.points[k].status == TrackStatus::ok && !changed[k]) {
      track.points[k].x += moved.x;
      track.points[k].y += moved.y;
    }
}

/// Light that stands in the picture: looked for in what the layers leave.
void note_light(const LayeredResult& result, bool coded, TrackSummary& summary) {
  if (coded) {
    summary.plan.push_back({"light that stands in the picture", false,
                            "not looked for in a coded recording: the coder's own errors bend the light", 0,
                            0, 0});
    return;
  }
  std::string text =
      fmt::format("the light over the disc is bent, by more than noise does it, in {:.0f} % of {} frames",
                  100 * result.bent_share, result.windows);
  if (result.light_rounds > 0)
    text += fmt::format(
        "; learnt with the layers in {} rounds and taken out: it had moved the disc by {:.4f} px rms",
        result.light_rounds, result.light_moved);
  summary.plan.push_back(
      {"light that stands in the picture", result.light_rounds > 0, text, 0, result.light_moved, 0});
}

}  // namespace

bool layers_wanted(const FirstPass& first, double radius, Layers layers) {
  if (layers == Layers::off || first.blur <= 0) return false;
  const double noise = std::sqrt(first.noise_variance);
  // The ring that the texture was measured in has this many pixels or more: noise alone scatters that much.
  const double pixels = std::numbers::pi * (std::pow(radius + 8, 2) - std::pow(radius + 4, 2));
  const double told = std::max(kTextureShare, std::sqrt(kScatter * std::sqrt(2 / pixels)));
  return layers == Layers::on || first.ground_texture > told * noise || first.excess > kExcessShare * noise;
}

bool layered_stage(FrameSource& source, const FirstPass& first, Layers layers, Track& track,
                   TrackSummary& summary, const std::function<void(std::int64_t)>& progress) {
  const auto off = [&](const std::string& reason) {
    summary.plan.push_back({kName, false, reason, 0, 0, first.layers_cost});
    return false;
  };
  if (layers == Layers::off) return off("switched off; " + finding(first));
  if (first.blur <= 0) return off("the part has no measured round rim");
  if (!layers_wanted(first, summary.disc.radius, layers)) return off(finding(first));

  std::vector<std::size_t> places;
  const std::vector<FirstPassFrame> frames = seen_frames(track, first, places);
  LayeredOptions options;
  options.disc = summary.disc;
  options.blur = first.blur;
  options.turning = first.turning;
  options.noise_variance = first.noise_variance;
  options.excess = first.excess;
  options.top_level = source.info().clipping_level();
  options.standing_light = !source.info().decoded;
  options.motion_known = track.has_marker;
  options.first_index = first.first_index;
  options.total = first.total;
  options.progress = progress;
  const LayeredResult result = layered_pass(source, frames, options);
  if (result.fixes.empty()) return off(result.why_not + "; " + finding(first));

  std::vector<bool> changed(track.points.size(), false);
  std::vector<double> limits;
  Point moved;
  double square = 0;
  for (std::size_t k = 0; k < places.size(); ++k) {
    if (!result.fixes[k]) continue;
    TrackPoint& p = track.points[places[k]];
    square += std::pow(result.fixes[k]->state.centre.x - p.x, 2) +
              std::pow(result.fixes[k]->state.centre.y - p.y, 2);
    moved.x += result.fixes[k]->state.centre.x - p.x;
    moved.y += result.fixes[k]->state.centre.y - p.y;
    change(p, *result.fixes[k]);
    changed[places[k]] = true;
    limits.push_back(std::sqrt(0.5 * result.fixes[k]->covariance.trace()));
  }
  if (limits.empty()) return off("the layers explain no frame; " + finding(first));
  const auto count = static_cast<double>(limits.size());
  // What it bought: how far, the mean not counted, the single template was from here.
  const double bought =
      std::sqrt(std::max(0.0, (square - (moved.x * moved.x + moved.y * moved.y) / count) / (2 * count)));
  keep_the_rest(track, changed, {moved.x / count, moved.y / count});
  std::nth_element(limits.begin(), limits.begin() + static_cast<std::ptrdiff_t>(limits.size() / 2),
                   limits.end());
  summary.limit_px = limits[limits.size() / 2];
  summary.slow_sd = result.slow_error.sd;
  const double duration = track.points.back().time_s - track.points.front().time_s;
  summary.slow_time =
      result.slow_error.frames * duration / std::max<double>(1, static_cast<double>(track.points.size()) - 1);
  if (result.disc_radius > 0) {
    summary.disc.radius = result.disc_radius;
    summary.disc_radius_sd = result.disc_radius_sd;
  }
  std::int64_t left = 0;
  for (std::size_t k = 0; k < track.points.size(); ++k)
    left += track.points[k].status == TrackStatus::ok && !changed[k];
  if (left > 0)
    summary.warnings.push_back(fmt::format(
        "{} frames keep the position of the first pass, in which the ground is seen through the rim (the "
        "ground about the part is not known there, or something covers it): their standard deviations are "
        "wider",
        left));
  summary.plan.push_back(
      {kName, true,
       finding(first) +
           fmt::format(
               "; learnt from {} frames, noise variance {:.2f} + {:.4f} I, at the rim {:.0f} % above it",
               result.windows, result.noise.constant, result.noise.per_level,
               100 * std::max(0.0, result.rim_excess)) +
           (result.crossed_share > 0
                ? fmt::format(
                      "; {:.2g} % of the ground beside it was crossed by something, which is left out",
                      100 * result.crossed_share)
                : std::string()) +
           fmt::format("; positions moved by {:.4f} px rms; errors share {:.5f} px over {:.2g} s", bought,
                       summary.slow_sd, summary.slow_time),
       0, bought, first.layers_cost});
  note_light(result, source.info().decoded, summary);
  return true;
}

}  // namespace tribotrack::vision
