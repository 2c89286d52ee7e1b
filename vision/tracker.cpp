#include "vision/tracker.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <stdexcept>

#include "vision/audit/audit.h"
#include "vision/camera/frame_cache.h"
#include "vision/camera/pixels.h"
#include "vision/coding/coded_errors.h"
#include "vision/edge/edge.h"
#include "vision/edge/radius.h"
#include "vision/layers/layers.h"
#include "vision/rotation/rotation.h"
#include "vision/stages/stages.h"
#include "vision/tracking/first_pass.h"
#include "vision/tracking/setup.h"

namespace tribotrack::vision {

void TrackOptions::validate() const {
  if (!(min_ncc > 0 && min_ncc < 1)) throw std::invalid_argument("min_ncc must lie between 0 and 1");
  if (!(max_lost_share >= 0 && max_lost_share <= 1))
    throw std::invalid_argument("max_lost_share must lie between 0 and 1");
  if (threads < 1) throw std::invalid_argument("threads must be at least 1");
  if (chamfer && !(*chamfer >= 0 && *chamfer < 1))
    throw std::invalid_argument("chamfer must be less than the radius and not negative");
  if (frame_step < 1) throw std::invalid_argument("frame_step must be at least 1");
  const auto check = [](const Circle& c, const char* what) {
    if (!(std::isfinite(c.x) && std::isfinite(c.y) && std::isfinite(c.radius) && c.radius > 0))
      throw std::invalid_argument(std::string(what) + " must have finite coordinates and a positive radius");
  };
  if (gate) check(*gate, "gate");
  if (target.kind == Target::Kind::disc) check(target.disc, "target.disc");
  if (marker.kind == MarkerChoice::Kind::tag) require_tag_family(marker.dictionary);
  if (marker.kind == MarkerChoice::Kind::circle) check(marker.circle, "marker.circle");
}

namespace {

constexpr double kRimReach = 2;  ///< px beside the rim's line: its blur

/// What a track is off by, px rms over its ok points, as far as its own covariances and the audit know.
double predicted_error(Track track, const std::vector<AuditFrame>& audited) {
  TrackSummary summary;
  apply(audit(audited, track), track, summary);
  double square = 0, count = 0;
  for (const TrackPoint& p : track.points) {
    if (p.status != TrackStatus::ok) continue;
    square += 0.5 * (p.sigma_x * p.sigma_x + p.sigma_y * p.sigma_y);
    ++count;
  }
  return count > 0 ? std::sqrt(square / count) : std::numeric_limits<double>::infinity();
}

/// What lies beyond the edge that is seen.
PlanStage chamfer_stage(const OuterEdge& edge, bool given) {
  const std::string ring =
      edge.measured
          ? fmt::format("a chamfer of {:.2f} px is seen in the rays of the mean picture", edge.widest)
      : given ? fmt::format("a chamfer of {:.2f} px is given", edge.widest)
              : fmt::format("a chamfer of up to {:.2f} px as dark as the ground would not show", edge.widest);
  return {
      .name = "chamfer",
      .on = edge.measured,
      .reason = fmt::format("{}; the outer edge lies {:.2f} px beyond the edge that is seen, sd {:.2f} px",
                            ring, edge.beyond, edge.beyond_sd),
      .error_bound_px = edge.measured ? std::optional<double>() : edge.beyond_sd};
}

/// Where the residual beyond the noise is large; levels rms.
std::optional<std::string> excess_warning(double excess, double noise) {
  if (!(excess > 0.5 * noise)) return std::nullopt;
  return fmt::format(
      "the registration leaves {:.2f} grey levels rms beyond the noise of {:.2f} (moving ground seen through "
      "the edge, glare, compression): the standard deviations are widened accordingly",
      excess, noise);
}

/// One call of track().
class Tracking {
 public:
  Tracking(FrameSource& recording, const TrackOptions& options)
      : recording_(recording),
        options_(options),
        timed_(recording, clock_),
        cache_(timed_),
        range_(frames_to_analyse(recording, options)) {}

  TrackResult run() {
    cache_first_frames(range_.first);
    check_camera_and_mend();
    find_first_frame();
    follow();
    measure_layers();
    measure_edge();
    follow_rotation();
    audit_track();
    allow_for_coding();
    const SeenFrames seen = seen_frames(result_.track, start_);
    measure_radius(seen);
    check_roundness(seen);
    prepend_absence();
    result_.stage_times = clock_.times();
    return std::move(result_);
  }

 private:
  void cache_first_frames(std::int64_t first);
  void check_camera_and_mend();
  void find_first_frame();
  void follow();
  void measure_layers();
  void prefer_first_pass(PassOutcome& layers);
  void measure_edge();
  bool take(PassOutcome pass, const char* from);
  void follow_rotation();
  void audit_track();
  void allow_for_coding();
  void measure_radius(const SeenFrames& seen);
  void check_roundness(const SeenFrames& seen);
  void prepend_absence();
  FrameSource& frames() {
    if (mended_) return *mended_;
    return cache_;
  }

  FrameSource& recording_;
  TrackOptions options_;
  StageClock clock_;
  TimedSource timed_;
  FrameCache cache_;
  FrameRange range_;  ///< of the frames to analyse
  Camera camera_;
  std::optional<MendedSource> mended_;  ///< where the camera has bad pixels
  Appearance appearance_;               ///< where the part is first seen
  std::int64_t start_ = 0;              ///< in that frame
  std::unique_ptr<FirstPass> first_pass_;
  std::vector<WatchedFrame> coded_;
  Track first_track_;                    ///< of the first pass
  std::optional<OuterEdge> outer_edge_;  ///< where it was looked for before, from the first pass' radius
  std::vector<AuditFrame> audited_;      ///< of the pass that the positions are from
  TrackResult result_;
};

/// The frames that are read several times before the tracking begins.
void Tracking::cache_first_frames(std::int64_t first) {
  constexpr int kFrames = std::max(kCameraFrames, kAveragedFrames);
  for (std::int64_t k = first; k <= std::min(range_.last, first + kFrames - 1); ++k)
    cache_.keep(k, cache_.bounds());
}

void Tracking::check_camera_and_mend() {
  const auto running = clock_.enter("camera: noise, bad pixels");
  camera_ = check_camera(cache_, range_);
  if (!camera_.bad_pixels.empty()) mended_.emplace(cache_, camera_.bad_pixels);
}

void Tracking::find_first_frame() {
  const auto running = clock_.enter("finding the part");
  appearance_ = first_appearance(frames(), range_, options_);
  start_ = appearance_.index;
  add(result_.summary.warnings, appearance_.warning);
}

void Tracking::follow() {
  cache_first_frames(start_);
  first_pass_ = std::make_unique<FirstPass>(frames(), FrameRange{start_, range_.last}, appearance_, camera_,
                                            options_, clock_, result_.summary);
  const FirstPassResult& first = first_pass_->result();
  for (std::int64_t k = 0; k < first.total; ++k) {
    if (const auto seen = first_pass_->step(start_ + k)) {
      cache_.keep(start_ + k, read_again(first, options_.layers, start_ + k, *seen, cache_.bounds()));
      if (recording_.info().coder)
        coded_.push_back(
            watched(recording_, start_ + k, {seen->x, seen->y, first.disc.radius}, first_pass_->mark()));
    }
    if (options_.progress) options_.progress((k + 1) / (options_.layers == Layers::off ? 1 : 2), first.total);
  }
  result_.track = first_pass_->finish();
  if (first_pass_->rim()) ask_if_it_rests(frames(), start_, result_.track, *first_pass_->rim(), options_);
}

/// The second pass, kept where it does better than the first.
void Tracking::measure_layers() {
  const FirstPassResult& first = first_pass_->result();
  const ShownFrames shown = frames_to_show(result_.track, first, options_);
  first_pass_->show(result_.track, shown);
  first_track_ = result_.track;
  audited_ = first.audited;
  TrackSummary& summary = result_.summary;
  PassOutcome layers = layered_stage(frames(), first, options_, shown, clock_, result_.track);
  if (recording_.info().coder && options_.layers == Layers::automatic) prefer_first_pass(layers);
  summary.layered = take(std::move(layers), "pictures");
  if (summary.layered) return;
  if (options_.layers == Layers::on)
    summary.warnings.push_back("the second pass that was asked for (--layers on) is not used: " +
                               summary.plan.back().reason);
  add(summary.warnings, excess_warning(first.excess, summary.noise_levels));
}

/// In frames of a lossy codec the ground lags, where that saves bits. Without a mark that tells its motion,
/// layers learnt over it err by a share of every displacement, beyond what they state; a template, which
/// knows no ground, does not.
void Tracking::prefer_first_pass(PassOutcome& layers) {
  // Of the two errors together: 0.6 to 1.2 in recordings in which layers do better, 1.8 to 4 where they do
  // not.
  constexpr double kContradicts = 1.5;
  const double differ = layers.stage.error_bound_px.value_or(0),
               explained = std::hypot(predicted_error(first_track_, audited_),
                                      predicted_error(result_.track, layers.audited));
  if (!layers.stage.on || differ <= kContradicts * explained) return;
  layers.stage.on = false;
  layers.stage.reason = fmt::format(
      "the recording is coded, and positions differ by {:.2g} px rms from those of the template, where the "
      "errors of both explain {:.2g}",
      differ, explained);
  result_.track = first_track_;
}

/// What turns in the part, or glints, spoils its pictures, not its edge.
void Tracking::measure_edge() {
  EdgeOutcome edge = edge_stage(frames(), first_pass_->result(), options_, clock_,
                                predicted_error(result_.track, audited_), result_.track);
  outer_edge_ = edge.outer;
  take(std::move(edge), "edge");
}

/// What a pass says that may have measured the frames again; whether it has.
bool Tracking::take(PassOutcome pass, const char* from) {
  TrackSummary& summary = result_.summary;
  summary.plan.push_back(pass.stage);
  if (!pass.stage.on) return false;
  audited_ = std::move(pass.audited);
  add(summary.warnings, pass.warnings);
  summary.limit_px = pass.limit_px;
  summary.slow.clear();
  if (pass.slow_sd > 0 && pass.slow_time > 0) summary.slow = {{from, pass.slow_sd, pass.slow_time}};
  return true;
}

/// At the final centres.
void Tracking::follow_rotation() {
  const auto running = clock_.enter("rotation by rings");
  measure_rotation(frames(), first_pass_->result(), result_.track, result_.summary.plan, options_.threads);
}

/// Of the pass that the positions are from.
void Tracking::audit_track() {
  const auto running = clock_.enter("audit");
  apply(audit(audited_, result_.track), result_.track, result_.summary);
}

/// What a lossy coder does beside what the audit finds.
void Tracking::allow_for_coding() {
  if (coded_.empty()) return;
  const auto running = clock_.enter("audit");
  CodedTrack coded{.coder = *recording_.info().coder, .frames = coded_, .first_index = start_};
  const std::int64_t first = coded.frames.front().index;
  const Picture picture = frames().read(first);
  const TrackPoint& at = result_.track.points[static_cast<std::size_t>(first - start_)];
  const Circle& mark = result_.summary.marker;
  const Circle part{at.x, at.y, first_pass_->result().disc.radius};
  coded.part_unnoticed = unnoticed_motion(picture, part, kRimReach);
  const double whole = std::hypot(picture.width(), picture.height());
  coded.mark_unnoticed = mark.radius > 0 ? unnoticed_motion(picture, mark, kRimReach)
                                         : unnoticed_motion(picture, {0, 0, whole}, -1);
  if (result_.summary.layered) coded.passes_differ = displacement_differs(result_.track, first_track_);
  widen_for_coding(coded, result_.track, result_.summary);
}

/// Of the edge as seen the mean over several frames, where the first frame or the layers show it; and of the
/// outer edge.
void Tracking::measure_radius(const SeenFrames& seen) {
  const auto running = clock_.enter("radius of the disc");
  TrackSummary& summary = result_.summary;
  summary.outer_radius = summary.disc.radius;
  summary.outer_radius_sd = summary.disc_radius_sd;
  if (!(summary.disc_blur > 0)) return;
  double common_sd = 0;
  if (const auto mean = seen_edge(frames(), seen, summary.disc.radius)) {
    summary.disc.radius = mean->circle.radius;
    summary.disc_radius_sd = mean->radius_sd;
    common_sd = mean->common_sd;
  }
  const FirstPassResult& first = first_pass_->result();
  OuterEdge edge = outer_edge_ ? *outer_edge_
                               : outer_edge(frames(), seen, summary.disc.radius, summary.disc_blur,
                                            first.noise_variance, options_.chamfer);
  if (outer_edge_ && edge.measured) edge.beyond += first.disc.radius - summary.disc.radius;
  summary.chamfer = edge.widest;
  summary.chamfer_known = options_.chamfer || edge.measured;
  summary.outer_radius = summary.disc.radius + edge.beyond;
  summary.outer_radius_sd = std::hypot(summary.disc_radius_sd, edge.beyond_sd);
  summary.outer_radius_common_sd = std::hypot(common_sd, edge.beyond_sd);
  summary.plan.push_back(chamfer_stage(edge, options_.chamfer.has_value()));
}

void Tracking::check_roundness(const SeenFrames& seen) {
  const double radius = result_.summary.disc.radius;
  if (seen.empty() || !(radius > 0)) return;
  const FirstPassFrame& first = seen.front();
  const Circle disc{first.centre.x, first.centre.y, radius};
  add(result_.summary.warnings, roundness_warning(frames().read(first.index), disc));
}

/// Frames before the part was there are lost, and not counted against the track.
void Tracking::prepend_absence() {
  std::vector<TrackPoint> before;
  for (std::int64_t index = range_.first; index < start_; ++index) {
    TrackPoint& point = before.emplace_back();
    point.frame = frames().number(index);
    point.time_s = frames().time_s(index);
    point.status = TrackStatus::lost;
  }
  auto& points = result_.track.points;
  points.insert(points.begin(), before.begin(), before.end());
  const auto absent = static_cast<std::int64_t>(before.size());
  result_.summary.frames += absent;
  result_.summary.lost += absent;
  result_.summary.absent_at_first = absent;
}

}  // namespace

TrackResult track(FrameSource& recording, const TrackOptions& options) {
  options.validate();
  if (!recording.info().time_base.known()) throw InputError(recording.info().time_base.why_unknown());
  return track_each_picture_once(recording, options, [](FrameSource& source, const TrackOptions& chosen) {
    return Tracking(source, chosen).run();
  });
}

}  // namespace tribotrack::vision
