#include "apps/recording/job.h"

#include <fmt/format.h>

#include "apps/files/camera.h"
#include "apps/program/errors.h"
#include "apps/recording/track_choices.h"
#include "apps/text/strict_toml.h"

namespace tribotrack::apps {

namespace {

vision::MarkerChoice marker_of(const CameraSection& camera) {
  if (camera.marker_px) return {vision::MarkerChoice::Kind::circle, *camera.marker_px};
  return camera.marker;
}

}  // namespace

void apply(const PartSection& part, const CameraSection& camera, RecordingJob& job) {
  job.frame_rate_hz = camera.frame_rate_hz;
  job.frame_rate_reason = camera.frame_rate_reason;
  job.mm_per_px = camera.mm_per_px;
  job.mm_per_px_sd = camera.mm_per_px_sd;
  job.calibration = camera.calibration;
  job.diameter_mm = part.diameter_mm;
  job.diameter_sd_mm = part.diameter_sd_mm;
  job.height_mm = part.height_mm;
  job.working_distance_mm = camera.working_distance_mm;
  job.xi_axis_rad = camera.xi_axis_rad;
  job.tag_mm = camera.tag_mm;
  job.tag_mm_sd = camera.tag_mm_sd;
  job.row_time_s = camera.row_time_s;
  const auto follow = [&job](const auto& place) {
    if (place.template_px) job.track.target = {vision::Target::Kind::rectangle, {}, *place.template_px};
    if (place.disc_px) job.track.target = {vision::Target::Kind::disc, *place.disc_px, {}};
  };
  follow(part);
  follow(camera);
  job.track.marker = marker_of(camera);
  job.track.gate = camera.gate_px;
}

RecordingJob job_for(const Campaign& campaign, const CampaignRun& run) {
  RecordingJob job;
  job.video = *run.video;
  CameraSection camera = campaign.camera;
  if (run.disc_px) {
    camera.disc_px = run.disc_px;
    camera.template_px.reset();
  }
  if (run.template_px) {
    camera.template_px = run.template_px;
    camera.disc_px.reset();
  }
  if (run.marker_px) camera.marker_px = run.marker_px;
  if (run.mm_per_px) {
    camera.mm_per_px = run.mm_per_px;
    camera.mm_per_px_sd = run.mm_per_px_sd.value_or(0);
  }
  apply(campaign.part, camera, job);
  if (job.mm_per_px) job.calibration.reset();
  if (job.mm_per_px || job.calibration) job.tag_mm.reset();
  if (job.mm_per_px || job.calibration || job.tag_mm) job.diameter_mm.reset();
  if (run.free_slide) {  // its platform rests and no actuator works
    if (!job.tag_mm) job.track.marker = {vision::MarkerChoice::Kind::none, {}};
    job.track.gate.reset();
  }
  job.track.first_frame = run.first_frame;
  job.track.last_frame = run.last_frame;
  return job;
}

namespace {

/// Frames/s: in-situ storage cameras reach 10^8 with some hundred frames; a higher rate is a slip.
constexpr double kFastestCamera = 1e9;

/// C.toml: [camera] and [part] as in a campaign, [track] min_ncc, max_lost_share, search_margin_px.
void apply_config(RecordingJob& job, const std::string& file) {
  StrictTable top = StrictTable::read(file);
  PartSection part;
  CameraSection camera;
  if (auto table = top.table("part")) part = read_part(*table, WithSd::no);
  if (auto table = top.table("camera"))
    camera = read_camera(*table, std::filesystem::path(file).parent_path(), WithSd::no);
  apply(part, camera, job);
  if (auto track = top.table("track")) {
    job.track.min_ncc = track->number("min_ncc").value_or(job.track.min_ncc);
    job.track.max_lost_share = track->not_negative("max_lost_share").value_or(job.track.max_lost_share);
    job.track.search_margin_px = static_cast<int>(track->integer("search_margin_px").value_or(0));
    track->finish();
  }
  top.finish();
}

bool is_positive(const char* flag, const std::optional<double>& value) {
  if (value && !(*value > 0))
    throw UsageError(fmt::format("{} must be greater than 0, not {}", flag, *value));
  return value.has_value();
}

void require_radius(const char* flag, const std::optional<vision::Circle>& circle) {
  if (circle && !(circle->radius > 0))
    throw UsageError(fmt::format("{} {},{},{}: the radius must be greater than 0", flag, circle->x, circle->y,
                                 circle->radius));
}

void apply_frame_rate(const TrackChoices& choices, RecordingJob& job) {
  if (is_positive("--fps", choices.fps)) {
    if (*choices.fps > kFastestCamera)
      throw UsageError(
          fmt::format("--fps {:g} is more than any camera records; give frames/s, at most {:.0e}",
                      *choices.fps, kFastestCamera));
    job.frame_rate_hz = choices.fps;
    job.frame_rate_reason.clear();
  }
  if (choices.fps_reason.empty()) return;
  if (!job.frame_rate_hz) throw UsageError("--fps-reason needs --fps");
  job.frame_rate_reason = choices.fps_reason;
}

void apply_scale(const TrackChoices& choices, RecordingJob& job) {
  if (choices.mm_per_px && choices.disc_diameter_mm)
    throw UsageError("give --mm-per-px or --disc-diameter-mm, not both");
  if (!choices.calibration.empty() && (choices.mm_per_px || choices.disc_diameter_mm))
    throw UsageError("--calibration gives the scale: leave out --mm-per-px and --disc-diameter-mm");
  if (is_positive("--mm-per-px", choices.mm_per_px)) {
    job.mm_per_px = choices.mm_per_px;
    job.mm_per_px_sd = 0;
    job.calibration.reset();
  }
  if (is_positive("--disc-diameter-mm", choices.disc_diameter_mm)) {
    job.diameter_mm = choices.disc_diameter_mm;
    job.diameter_sd_mm = 0;
    job.mm_per_px.reset();
    job.calibration.reset();
  }
  if (!choices.calibration.empty()) {
    job.calibration = choices.calibration;
    job.mm_per_px.reset();
  }
  if (is_positive("--tag-mm", choices.tag_mm)) {
    if (choices.mm_per_px || choices.disc_diameter_mm || !choices.calibration.empty())
      throw UsageError("--tag-mm gives the scale: leave out --mm-per-px, --disc-diameter-mm, --calibration");
    job.tag_mm = choices.tag_mm;
    job.tag_mm_sd = 0;
    job.mm_per_px.reset();
    job.calibration.reset();
  }
  if (is_positive("--height-mm", choices.height_mm)) job.height_mm = choices.height_mm;
  if (is_positive("--working-distance-mm", choices.working_distance_mm))
    job.working_distance_mm = choices.working_distance_mm;
  if (choices.xi_axis_rad) job.xi_axis_rad = *choices.xi_axis_rad;
}

void apply_target(const TrackChoices& choices, RecordingJob& job) {
  require_radius("--disc", choices.disc);
  require_radius("--gate", choices.gate);
  if (choices.disc && choices.rectangle) throw UsageError("give --disc or --template, not both");
  if (choices.disc) {
    job.track.target.kind = vision::Target::Kind::disc;
    job.track.target.disc = *choices.disc;
  } else if (choices.rectangle) {
    if (!(choices.rectangle->width > 0 && choices.rectangle->height > 0))
      throw UsageError("--template must have a width and a height greater than 0");
    job.track.target.kind = vision::Target::Kind::rectangle;
    job.track.target.rectangle = *choices.rectangle;
  }
  if (choices.marker) {
    if (choices.marker->kind == vision::MarkerChoice::Kind::circle)
      require_radius("--marker", choices.marker->circle);
    job.track.marker = *choices.marker;
  }
  if (job.tag_mm && job.track.marker.kind != vision::MarkerChoice::Kind::tag)
    throw UsageError("--tag-mm is the size of a tag; say which: --marker tag:apriltag_36h11");
  if (choices.gate) job.track.gate = choices.gate;
}

void apply_layers(const TrackChoices& choices, RecordingJob& job) {
  if (choices.layers == "off")
    job.track.layers = vision::Layers::off;
  else if (choices.layers == "on")
    job.track.layers = vision::Layers::on;
  else if (!choices.layers.empty() && choices.layers != "auto")
    throw UsageError(fmt::format("--layers must be auto, on or off, not \"{}\"", choices.layers));
  if (job.track.layers == vision::Layers::on && job.track.target.kind == vision::Target::Kind::rectangle)
    throw UsageError("--layers on needs a disc with a round rim, and --template follows a rectangle");
}

}  // namespace

RecordingJob job_of(const std::filesystem::path& video, const TrackChoices& choices) {
  RecordingJob job;
  job.video = video;
  if (!choices.config.empty()) apply_config(job, choices.config);
  apply_frame_rate(choices, job);
  apply_scale(choices, job);
  apply_target(choices, job);
  job.track.first_frame = choices.first_frame;
  job.track.last_frame = choices.last_frame;
  if (choices.first_frame && choices.last_frame && *choices.first_frame > *choices.last_frame)
    throw UsageError(fmt::format("--frames {}:{}: the first frame comes after the last", *choices.first_frame,
                                 *choices.last_frame));
  apply_layers(choices, job);
  return job;
}

}  // namespace tribotrack::apps
