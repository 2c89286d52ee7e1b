#include "vision/tracking/first_pass.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "vision/kernels/dense.h"
#include "vision/kernels/median.h"
#include "vision/kernels/plane.h"

namespace tribotrack::vision {
namespace {

/// The call's result, its time counted for a stage.
auto timed(StageClock& clock, const char* stage, const auto& call) {
  const auto running = clock.enter(stage);
  return call();
}

void fill(TrackPoint& point, PartLook& look, const Sighting& s) {
  point.status = TrackStatus::ok;
  point.x = s.position.x;
  point.y = s.position.y;
  point.ncc = s.ncc;
  set_covariance(point, s.covariance);
  look = {s.pose.theta, s.sigma_theta, s.residual_rms, s.by_rim};
}

PlanStage bad_pixels_stage(std::size_t found) {
  if (found == 0)
    return {.name = "bad pixels",
            .reason = "no pixel differs from all its neighbours in all of the first frames",
            .error_bound_px = 0};  // nothing to replace: the pictures are the same either way
  return {.name = "bad pixels",
          .on = true,
          .reason = fmt::format("{} differ from their neighbours in all of the first frames and are replaced "
                                "by the median of the neighbours",
                                found)};
}

/// In how many of the frames in which the part was seen the rim alone measures it.
PlanStage rim_stage(std::int64_t by_rim, std::int64_t seen) {
  return {
      .name = "rim alone",
      .on = by_rim > 0,
      .reason =
          by_rim > 0
              ? fmt::format("the template was not confirmed in {} of {} frames in which the part's edge was: "
                            "those are measured by the edge",
                            by_rim, seen)
              : fmt::format("the template was confirmed in all {} frames", seen)};
}

}  // namespace

FirstPass::FirstPass(FrameSource& source, const FrameRange& range, const Appearance& seen,
                     const Camera& camera, const TrackOptions& options, StageClock& clock,
                     TrackSummary& summary)
    : source_(source),
      options_(options),
      clock_(clock),
      summary_(summary),
      first_(source.read(range.first)),
      setup_(timed(clock, "template of the part",
                   [&] {
                     summary.plan.push_back(bad_pixels_stage(camera.bad_pixels.size()));
                     return set_up_part(first_, source, range, seen, options, camera.noise_variance, summary);
                   })),
      part_(setup_.average.picture(first_), range.first, setup_.pattern, setup_.follow, setup_.shape),
      marker_(timed(clock, "first pass: marker", [&] {
        return set_up_marker(first_, source, range, options, camera.noise_variance, setup_.result.disc,
                             summary);
      })) {
  if (options.gate) lamp_.emplace(*options.gate, source);
  summary.gate_pixels = lamp_ ? lamp_->pixels() : 0;
  if (options.marker.kind == MarkerChoice::Kind::automatic) {  // the ground, where it moves
    const auto running = clock.enter("first pass: marker");
    glance_.emplace(first_, over_ground(setup_.pattern.centre, setup_.pattern, options), range.first,
                    range.last, kGroundGlance, camera.noise_variance);
  }
  last_seen_ = setup_.pattern.centre;
  track_.has_marker = marker_.has_value();
  track_.has_gate = lamp_.has_value();
}

std::optional<Point> FirstPass::step(std::int64_t index) {
  TrackPoint& point = track_.points.emplace_back();
  point.frame = source_.number(index);
  point.time_s = source_.time_s(index);
  const FollowStep step = follow_part(index);
  follow_marker(index, point);
  sample_lamp(index, point);
  glance_at_ground(index, step);
  if (!step.sighting) return std::nullopt;
  return step.sighting->position;
}

std::optional<Circle> FirstPass::mark() const {
  const auto& seen = track_.points.back().marker;
  if (!seen || !(summary_.marker.radius > 0)) return std::nullopt;
  return Circle{seen->x, seen->y, summary_.marker.radius};
}

/// Fills the last point.
FollowStep FirstPass::follow_part(std::int64_t index) {
  auto& points = track_.points;
  FirstPassResult& result = setup_.result;
  const bool audited = in_audit(index - result.first_index, result.total);
  FollowStep step = timed(clock_, "first pass: part", [&] { return part_.step(source_, index, audited); });
  if (step.confirms_previous && tentative_) {
    fill(points[points.size() - 2], result.looks.back(), *tentative_);
    ++refound_;
    if (step.came_back) came_back_.push_back(points.size() - 2);
  }
  tentative_ = step.status == TrackStatus::ok ? std::nullopt : step.sighting;
  points.back().status = step.status;
  result.looks.emplace_back();
  if (step.status != TrackStatus::ok) return step;
  fill(points.back(), result.looks.back(), *step.sighting);
  if (!step.sighting->by_rim) excess_.push_back(step.sighting->excess_rms);
  if (step.sighting->halves)
    result.audited.push_back({index, *step.sighting->halves, step.sighting->covariance});
  return step;
}

void FirstPass::follow_marker(std::int64_t index, TrackPoint& point) {
  if (!marker_) return;
  const auto running = clock_.enter("first pass: marker");
  const FollowStep step = marker_->step(source_, index);
  if (step.status != TrackStatus::ok) return;
  const Sighting& s = *step.sighting;
  point.marker = MarkerPoint{s.position.x, s.position.y, std::sqrt(0.5 * s.covariance.trace()), s.ncc};
}

void FirstPass::sample_lamp(std::int64_t index, TrackPoint& point) {
  if (!lamp_) return;
  const auto running = clock_.enter("first pass: gate lamp");
  const GateLamp::Sample light = lamp_->sample(source_, index);
  point.gate = light.level;
  summary_.gate_clipped_share = std::max(summary_.gate_clipped_share, light.clipped_share);
}

void FirstPass::glance_at_ground(std::int64_t index, const FollowStep& step) {
  if (step.sighting) last_seen_ = step.sighting->position;
  if (!glance_ || !glance_->wants(index)) return;
  const auto running = clock_.enter("first pass: marker");
  glance_->see(source_, index, over_ground(last_seen_, setup_.pattern, options_));
}

/// Where it serves as the marker, or is seen to move.
void FirstPass::follow_ground() {
  using Kind = MarkerChoice::Kind;
  const auto running = clock_.enter("first pass: marker");
  if (glance_) {
    const GroundVerdict ground = look_at_ground(glance_->sample(), setup_.result.noise_variance);
    if (!ground.moves) summary_.plan.push_back(ground_marker_stage(ground.reason, 0));
    if (!ground.moves) return;
  } else if (options_.marker.kind != Kind::texture &&
             (options_.marker.kind != Kind::find || track_.has_marker)) {
    return;
  }
  follow_platform(source_, setup_.result, options_, setup_.pattern, track_, summary_);
}

Track FirstPass::finish() {
  for (const std::size_t begin : came_back_) add(summary_.warnings, without_a_mark(track_, begin));
  follow_ground();
  static_cast<FrameCounts&>(summary_) = count(track_, options_.max_lost_share);
  summary_.refound = refound_;
  if (part_.ended())
    summary_.warnings.push_back(fmt::format(
        "the track ends before frame {}: from there on others that look like the part may have come to where "
        "it "
        "is seen; record at a higher rate, or mark the part",
        source_.number(*part_.ended())));
  if (setup_.shape) {
    const auto by_rim = std::ranges::count(setup_.result.looks, true, &PartLook::by_rim);
    summary_.plan.push_back(rim_stage(by_rim, summary_.ok));
  }
  if (options_.target.kind == Target::Kind::find_disc) {
    const auto still = rest_warning(track_, summary_.disc, false);
    add(summary_.warnings, still ? still : rest_warning(track_, summary_.disc, true));
    summary_.rests_for_ever = still.has_value();
    if (still) summary_.gate_passed = false;
  }
  setup_.result.excess = median(excess_);
  return std::move(track_);
}

void FirstPass::show(const Track& track, const ShownFrames& frames) {
  if (!options_.debug) return;
  show_first_pass(setup_, first_, track, frames, source_, *options_.debug);
}

GateLamp::GateLamp(const Circle& circle, const FrameSource& source) : top_(source.info().clipping_level()) {
  const int x0 = static_cast<int>(std::floor(circle.x - circle.radius));
  const int y0 = static_cast<int>(std::floor(circle.y - circle.radius));
  const int x1 = static_cast<int>(std::ceil(circle.x + circle.radius));
  const int y1 = static_cast<int>(std::ceil(circle.y + circle.radius));
  window_ = {x0, y0, x1 - x0 + 1, y1 - y0 + 1};
  if (!(circle.radius > 0) || !source.bounds().contains(window_)) {
    throw InputError(fmt::format(
        "{}: the gate's lamp at ({:g}, {:g}) px with radius {:g} px is not wholly in the {} x {} picture; "
        "correct gate_px",
        source.info().path.string(), circle.x, circle.y, circle.radius, source.info().width,
        source.info().height));
  }
  mask_ = cv::Mat(window_.height, window_.width, CV_8U);
  for (int y = 0; y < window_.height; ++y)
    for (int x = 0; x < window_.width; ++x)
      mask_.at<unsigned char>(y, x) = in_circle(circle, window_.x + x, window_.y + y);
}

GateLamp::Sample GateLamp::sample(FrameSource& source, std::int64_t index) {
  source.read(index, window_, picture_);
  const cv::Mat levels = matrix_of(picture_), clipped = (levels >= top_) & (mask_ > 0);
  return {cv::mean(levels, mask_)[0], static_cast<double>(cv::countNonZero(clipped)) / pixels()};
}

}  // namespace tribotrack::vision
