#include "vision/edge/stage.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "vision/kernels/median.h"

namespace tribotrack::vision {
namespace {

constexpr const char* kName = "edge in bands of time";
constexpr double kTurnVisible = 0.05;  ///< px rms at the rim: less rotation does not show
constexpr double kWorth = 1.2;         ///< of the bound: a track that is as good gains a tenth at most
constexpr double kSmallest = 6;        ///< px of radius: below, rays from all sides meet

/// Whether the part turns visibly: its angles vary more over the recording than they scatter from frame to
/// frame.
bool turns(const FirstPassResult& first, const Track& track) {
  if (!first.turning) return false;
  std::vector<double> theta;
  for (std::size_t k = 0; k < track.points.size(); ++k)
    if (track.points[k].status == TrackStatus::ok) theta.push_back(first.theta[k]);
  double mean = 0, total = 0, white = 0;
  const auto n = static_cast<double>(theta.size());
  for (const double t : theta) mean += t / n;
  for (std::size_t k = 0; k < theta.size(); ++k) {
    total += std::pow(theta[k] - mean, 2) / n;
    if (k > 0) white += 0.5 * std::pow(theta[k] - theta[k - 1], 2) / (n - 1);
  }
  return total - white > std::pow(kTurnVisible / first.disc.radius, 2);
}

double variance(const TrackPoint& p) {
  return 0.5 * (p.sigma_x * p.sigma_x + p.sigma_y * p.sigma_y);
}

/// Of a coordinate, px^2.
struct Variances {
  double of_edge = 0;  ///< as its sectors tell it
  double differ = 0;   ///< between edge and track, without the mean
};

using Fixes = std::vector<std::pair<std::size_t, RimFix>>;  ///< by point number

Variances compare(const Track& track, const Fixes& fixes) {
  Variances out;
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  double squares = 0;
  const auto count = static_cast<double>(fixes.size());
  for (const auto& [place, fix] : fixes) {
    const TrackPoint& p = track.points[place];
    const Eigen::Vector2d d(fix.centre.x - p.x, fix.centre.y - p.y);
    sum += d;
    squares += d.squaredNorm();
    out.of_edge += 0.5 * fix.covariance.trace() / count;
  }
  out.differ = std::max(0.0, squares - sum.squaredNorm() / count) / (2 * count);
  return out;
}

/// Why the edge need not be looked at; empty where it must.
std::string reason_against(const FirstPassResult& first, const TrackOptions& options, bool coded,
                           bool turning, double stated) {
  if (options.layers == Layers::off) return "switched off with the second pass";
  if (first.blur <= 0) return "the part has no measured round edge";
  if (first.disc.radius < kSmallest) return "the part is too small";
  if (coded && !turning) return "the part does not turn visibly, and lossy compression moves an edge as well";
  if (stated < kWorth * first.limit_px)
    return fmt::format("the part's pictures give {:.2g} px, noise alone allows {:.2g} px", stated,
                       first.limit_px);
  return {};
}

}  // namespace

EdgeOutcome edge_stage(FrameSource& source, const FirstPassResult& first, const TrackOptions& options,
                       StageClock& clock, double stated, Track& track) {
  const bool coded = source.info().coder.has_value(), turning = turns(first, track);
  EdgeOutcome out;
  PlanStage& stage = out.plan.emplace_back(
      PlanStage{.name = kName, .reason = reason_against(first, options, coded, turning, stated)});
  if (!stage.reason.empty()) return out;
  const auto running = clock.enter("edge in bands");
  const auto [frames, places] = seen_frames(track, first.first_index);
  const EdgeTrack edge = track_edge(
      source, frames,
      {.radius = first.disc.radius, .noise_variance = first.noise_variance, .threads = options.threads});
  if (edge.fixes.empty()) {
    stage.reason = edge.why_not;
    return out;
  }
  Fixes fixes;
  for (std::size_t i = 0; i < places.size(); ++i)
    if (edge.fixes[i]) fixes.emplace_back(places[i], *edge.fixes[i]);
  const Variances v = compare(track, fixes);
  // Pictures of a part that turns hold what turns with it: a difference is their error first. What a lossy
  // coder does moves an edge as well.
  const double of_track = std::max(stated * stated, turning && !coded ? v.differ : v.differ - v.of_edge);
  stage.on = out.done = v.of_edge < of_track;
  stage.reason = fmt::format(
      "learnt from {} frames: edge at {:.2f} px, blur {:.2f} px, chamfer {:.2f} px; predicted errors: {:.2g} "
      "px by the edge, of "
      "them {:.2g} px slow, {:.2g} px by the part's pictures; they differ by {:.2g} px rms",
      edge.learnt_from, edge.radius, edge.optics.blur, edge.optics.chamfer, std::sqrt(v.of_edge),
      edge.slow_sd, std::sqrt(of_track), std::sqrt(v.differ));
  if (!out.done) return out;
  std::vector<double> sds;
  for (const auto& [place, fix] : fixes) {
    TrackPoint& p = track.points[place];
    p.x = fix.centre.x;
    p.y = fix.centre.y;
    p.sigma_x = std::sqrt(fix.covariance(0, 0));
    p.sigma_y = std::sqrt(fix.covariance(1, 1));
    p.rho_xy = fix.covariance(0, 1) / (p.sigma_x * p.sigma_y);
    sds.push_back(std::sqrt(variance(p)));
  }
  out.limit_px = median(sds);
  out.slow_sd = edge.slow_sd;
  const double duration = track.points.back().time_s - track.points.front().time_s;
  out.slow_time =
      edge.slow_frames * duration / static_cast<double>(std::max<std::size_t>(1, frames.size() - 1));
  return out;
}

}  // namespace tribotrack::vision
