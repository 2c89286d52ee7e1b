#include "vision/layers/layers.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "vision/discs/disc_detection.h"
#include "vision/io/levels.h"

namespace tribotrack::vision {
namespace {

constexpr const char* kName = "layers: part over platform";
constexpr double kNegligible = 1;     ///< of the noise: a ground that moves a position by less is not learnt
constexpr std::size_t kFewest = 12;   ///< frames to learn from
constexpr int kContext = 6;           ///< px kept beyond the part's grid
constexpr int kTaper = 4;             ///< px of the grid in which ground is taken to be uncovered
constexpr double kFewestKnown = 0.2;  ///< share of the ground that must be seen beside the part's grid
constexpr double kClear = 6;          ///< blurs beside the rim
constexpr double kExplained = 0.1;    ///< of the noise: what may be left where a template explains the part

/// Px about the part's centre that are looked at in every frame.
double layered_reach(double radius, double blur) {
  return layered_half(radius, blur) + kContext;
}

std::string finding(const FirstPassResult& first) {
  return fmt::format(
      "the ground has a texture of {:.2f} grey levels rms and a single template leaves {:.2f} unexplained, "
      "against noise of {:.2f}",
      first.ground_texture, first.excess, std::sqrt(first.noise_variance));
}

PassOutcome left_out(std::string reason, std::optional<double> error_bound_px = {}) {
  PassOutcome out;
  out.stage = {.name = kName, .reason = std::move(reason), .error_bound_px = error_bound_px};
  return out;
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
  const bool by_template = std::ranges::none_of(first.looks, &PartLook::by_rim);
  return by_template && first.contrast > 0 && pull_of_ground(first) < kNegligible * first.limit_px &&
         first.excess < kExplained * std::sqrt(first.noise_variance);
}

/// Where the stage is not even tried, why.
std::optional<PassOutcome> reason_against(const FirstPassResult& first, const Track& track, Layers layers) {
  if (first.blur <= 0) return left_out("the part has no measured round edge");
  if (layers == Layers::off) return left_out("switched off; " + finding(first));
  if (layers == Layers::on || !nothing_to_learn(first, track)) return std::nullopt;
  const double pull = pull_of_ground(first);
  return left_out(
      fmt::format("nothing to learn: {}; through the edge the ground moves a position by {:.2g} px at most",
                  finding(first), pull),
      pull);
}

/// The ok points that were not measured again move by this, so that both passes refer to the same point of
/// the disc. How many these are.
std::int64_t move_rest(Track& track, const SeenFrames& frames,
                       const std::vector<std::optional<Remeasured>>& fixes, const Point& by) {
  std::vector<bool> measured(track.points.size(), false);
  for (std::size_t k = 0; k < frames.size(); ++k) measured[frames[k].place] = fixes[k].has_value();
  std::int64_t count = 0;
  for (std::size_t k = 0; k < track.points.size(); ++k) {
    TrackPoint& p = track.points[k];
    if (p.status != TrackStatus::ok || measured[k]) continue;
    p.x += by.x;
    p.y += by.y;
    ++count;
  }
  return count;
}

/// Positions are those of the rim's centre in the averaged picture.
std::vector<std::optional<Remeasured>> centres_of_rim(const MeasuredFrames& measured,
                                                      const PartPictures& part, double radius) {
  const double half = part.half;
  const auto rim = fit_disc(part.level, {half, half, radius}, 2);
  const Point off = rim ? Point{rim->circle.x - half, rim->circle.y - half} : Point{};
  std::vector<std::optional<Remeasured>> out;
  for (const auto& fix : measured.fixes) {
    out.emplace_back();
    if (!fix) continue;
    const Point& c = fix->state.centre;
    out.back() = Remeasured{{c.x + off.x, c.y + off.y}, fix->covariance, fix->ncc};
  }
  return out;
}

PlanStage used(const FirstPassResult& first, const LearntPart& learnt, std::size_t windows, double slow_sd,
               double moved) {
  // Of what the frames tell at a place its share of the ground and the ground there take one frame's each.
  return {
      .name = kName,
      .on = true,
      .reason = fmt::format("{}; learnt from {} frames in {} rounds; {:.4f} px of the errors change slowly; "
                            "positions moved by {:.4f} px rms; what frames share through the noise of the "
                            "pictures, some {:.1f} % of a position's variance, is not counted between them",
                            finding(first), windows, learnt.rounds, slow_sd, moved,
                            200.0 / static_cast<double>(std::max<std::size_t>(1, windows))),
      .error_bound_px = moved};
}

}  // namespace

bool is_learning_frame(std::int64_t place, std::int64_t total) {
  if (total <= kLearningFrames) return true;
  const std::int64_t last = total - 1, parts = kLearningFrames - 1;
  const std::int64_t next = (place * parts + last - 1) / last;  // the first that does not lie before it
  return next * last / parts == place;
}

int layered_half(double radius, double blur) {
  // The rim's blur, and a shadow: of a part a quarter of its radius high, a lamp at 45 degrees throws one of
  // a quarter of the radius.
  return static_cast<int>(std::ceil(radius * 1.25 + 4 * blur)) + kTaper;
}

PassOutcome layered_stage(FrameSource& source, const FirstPassResult& first, const TrackOptions& options,
                          const ShownFrames& shown, StageClock& clock, Track& track) {
  if (auto against = reason_against(first, track, options.layers)) return *against;
  const SeenFrames frames = seen_frames(track, first.first_index, true);
  if (frames.size() < kFewest) return left_out("too few frames to learn the layers from; " + finding(first));
  const auto learning_runs = clock.enter("layers: learning");
  double hidden = layered_half(first.disc.radius, first.blur) - kTaper;  // px about the part: no ground
  LearningFrames learning(source, frames, first, layered_reach(first.disc.radius, first.blur));
  GroundPicture ground(learning.region());
  learning.read_ground(ground, hidden);
  // A picture that holds little more than the part shows its ground beside it only, in what shadow there is.
  if (ground.known_share() < kFewestKnown) {
    hidden = first.disc.radius + kClear * first.blur;
    learning.read_ground(ground, hidden);
  }
  std::vector<KeptWindow> windows = learning.read_windows();
  LayeredRegistration registration(ground);
  const LearntPart learnt = learn_part(windows, ground, registration, first, hidden, options.threads);
  if (learnt.explained < kFewest)
    return left_out("the pictures learnt explain hardly any frame; " + finding(first));
  const auto measuring_runs = clock.enter("layers: measuring");
  MeasuredFrames measured =
      measure_frames(source, frames, registration, learnt, options.threads, [&](std::int64_t done) {
        if (options.progress) options.progress((first.total + done) / 2, first.total);
      });
  if (options.debug) {
    const auto showing = clock.enter("debug pictures");
    show_layers(learnt.part, ground, measured, frames, shown, source, *options.debug);
  }

  const auto fixes = centres_of_rim(measured, learnt.part, first.disc.radius);
  const Remeasurement change = compare(track, frames, fixes);
  if (change.count == 0) return left_out("the layers explain no frame; " + finding(first));
  replace(track, frames, fixes);
  const std::int64_t kept = move_rest(track, frames, fixes, change.moved);
  PassOutcome out;
  out.stage = used(first, learnt, windows.size(), measured.slow_sd, change.differ);
  out.limit_px = change.median_sd;
  out.slow_sd = measured.slow_sd;
  const double duration = track.points.back().time_s - track.points.front().time_s;
  out.slow_time =
      measured.slow_frames * duration / std::max<double>(1, static_cast<double>(track.points.size()) - 1);
  out.audited = std::move(measured.audited);
  if (kept > 0)
    out.warnings.push_back(fmt::format(
        "{} frames keep the position of the first pass, in which the ground is seen through the edge "
        "(the ground about the part is not known there, or something covers it): their standard deviations "
        "are wider",
        kept));
  return out;
}

Rect read_again(const FirstPassResult& first, Layers layers, std::int64_t index, const Point& centre,
                const Rect& bounds) {
  const bool layered = layers != Layers::off && first.blur > 0;
  if (!layered && !first.texture_seen) return {};
  if (layered && is_learning_frame(index - first.first_index, first.total)) return bounds;
  const double reach =
      layered ? layered_reach(first.disc.radius, first.blur) : rings_reach(first.disc.radius);
  return window_about(centre, reach + 1, bounds);  // a later pass may round the centre otherwise
}

}  // namespace tribotrack::vision
