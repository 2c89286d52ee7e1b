#include "apps/recording/recording.h"

#include <fmt/format.h>

#include "apps/files/camera.h"
#include "apps/program/errors.h"
#include "apps/text/strict_toml.h"

namespace tribotrack::apps {

namespace {

void set_chamfer(Recording& recording) {
  const PartSection& part = recording.part;
  if (part.chamfer_mm && part.diameter_mm)
    recording.options.chamfer = *part.chamfer_mm / (0.5 * *part.diameter_mm);
}

/// What is followed, by [part] and [camera].
void set_target(Recording& recording) {
  const auto follow = [&](const auto& place) {
    vision::Target& target = recording.options.target;
    if (place.template_px) target = {vision::Target::Kind::rectangle, {}, *place.template_px};
    if (place.disc_px) target = {vision::Target::Kind::disc, *place.disc_px, {}};
  };
  follow(recording.part);
  follow(recording.camera);
  const CameraSection& camera = recording.camera;
  recording.options.marker = camera.marker;
  if (camera.marker_px) recording.options.marker = {vision::MarkerChoice::Kind::circle, *camera.marker_px};
  recording.options.gate = camera.gate_px;
}

}  // namespace

Recording recording_of(const Campaign& campaign, const CampaignRun& run) {
  Recording recording;
  recording.video = *run.video;
  recording.part = campaign.part;
  CameraSection& camera = recording.camera = campaign.camera;
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
  set_target(recording);
  set_chamfer(recording);
  if (camera.mm_per_px) camera.calibration.reset();
  if (camera.mm_per_px || camera.calibration) camera.tag_mm.reset();
  if (camera.mm_per_px || camera.calibration || camera.tag_mm) recording.part.diameter_mm.reset();
  if (run.free_slide) {  // its platform rests and no actuator works
    if (!camera.tag_mm) recording.options.marker = {vision::MarkerChoice::Kind::none, {}};
    recording.options.gate.reset();
  }
  recording.options.first_frame = run.first_frame;
  recording.options.last_frame = run.last_frame;
  recording.options.frame_step = run.frame_step;
  return recording;
}

namespace {

/// Frames/s: in-situ storage cameras reach 10^8 with some hundred frames; a higher rate is a slip.
constexpr double kFastestCamera = 1e9;

/// C.toml: [camera] and [part] as in a campaign, [track] min_ncc, max_lost_share, search_margin_px.
void apply_config(Recording& recording, const std::string& file) {
  StrictTable top = StrictTable::read(file);
  if (auto table = top.table("part")) recording.part = read_part(*table, WithSd::no);
  if (auto table = top.table("camera"))
    recording.camera = read_camera(*table, std::filesystem::path(file).parent_path(), WithSd::no);
  set_target(recording);
  if (auto track = top.table("track")) {
    recording.options.min_ncc = track->number("min_ncc").value_or(recording.options.min_ncc);
    recording.options.max_lost_share =
        track->not_negative("max_lost_share").value_or(recording.options.max_lost_share);
    recording.options.search_margin_px = static_cast<int>(track->integer("search_margin_px").value_or(0));
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

void apply_frame_rate(const TrackChoices& choices, Recording& recording) {
  CameraSection& camera = recording.camera;
  if (is_positive("--fps", choices.fps)) {
    if (*choices.fps > kFastestCamera)
      throw UsageError(
          fmt::format("--fps {:g} is more than any camera records; give frames/s, at most {:.0e}",
                      *choices.fps, kFastestCamera));
    camera.frame_rate_hz = choices.fps;
    camera.frame_rate_reason.clear();
  }
  if (choices.fps_reason.empty()) return;
  if (!camera.frame_rate_hz) throw UsageError("--fps-reason needs --fps");
  camera.frame_rate_reason = choices.fps_reason;
}

void apply_scale(const TrackChoices& choices, Recording& recording) {
  CameraSection& camera = recording.camera;
  if (!choices.calibration.empty() && choices.mm_per_px)
    throw UsageError("--calibration gives the scale: leave out --mm-per-px");
  if (is_positive("--mm-per-px", choices.mm_per_px)) {
    camera.mm_per_px = choices.mm_per_px;
    camera.mm_per_px_sd = 0;
    camera.calibration.reset();
  }
  if (is_positive("--disc-diameter-mm", choices.disc_diameter_mm)) {
    recording.part.diameter_mm = choices.disc_diameter_mm;
    recording.part.diameter_sd_mm = 0;
    if (!choices.mm_per_px) camera.mm_per_px.reset();
    camera.calibration.reset();
  }
  if (choices.chamfer_mm) {
    if (!recording.part.diameter_mm) throw UsageError("--chamfer-mm needs --disc-diameter-mm");
    if (!can_be_chamfer(*choices.chamfer_mm, *recording.part.diameter_mm))
      throw UsageError(fmt::format("--chamfer-mm {:g} must be less than the radius and not negative",
                                   *choices.chamfer_mm));
    recording.part.chamfer_mm = choices.chamfer_mm;
  }
  if (!choices.calibration.empty()) {
    camera.calibration = choices.calibration;
    camera.mm_per_px.reset();
  }
  if (is_positive("--tag-mm", choices.tag_mm)) {
    if (choices.mm_per_px || !choices.calibration.empty())
      throw UsageError("--tag-mm gives the scale: leave out --mm-per-px and --calibration");
    camera.tag_mm = choices.tag_mm;
    camera.tag_mm_sd = 0;
    camera.mm_per_px.reset();
    camera.calibration.reset();
  }
  if (is_positive("--height-mm", choices.height_mm)) recording.part.height_mm = choices.height_mm;
  if (is_positive("--working-distance-mm", choices.working_distance_mm))
    camera.working_distance_mm = choices.working_distance_mm;
  if (choices.xi_axis_rad) camera.xi_axis_rad = *choices.xi_axis_rad;
}

void apply_target(const TrackChoices& choices, Recording& recording) {
  require_radius("--disc", choices.disc);
  require_radius("--gate", choices.gate);
  if (choices.disc && choices.rectangle) throw UsageError("give --disc or --template, not both");
  if (choices.rectangle && !(choices.rectangle->width > 0 && choices.rectangle->height > 0))
    throw UsageError("--template must have a width and a height greater than 0");
  vision::TrackOptions& options = recording.options;
  if (choices.disc) options.target = {vision::Target::Kind::disc, *choices.disc, {}};
  if (choices.rectangle) options.target = {vision::Target::Kind::rectangle, {}, *choices.rectangle};
  if (choices.marker) {
    if (choices.marker->kind == vision::MarkerChoice::Kind::circle)
      require_radius("--marker", choices.marker->circle);
    options.marker = *choices.marker;
  }
  if (recording.camera.tag_mm && options.marker.kind != vision::MarkerChoice::Kind::tag)
    throw UsageError("--tag-mm is the size of a tag; say which: --marker tag:apriltag_36h11");
  if (choices.gate) options.gate = choices.gate;
}

void apply_layers(const TrackChoices& choices, Recording& recording) {
  vision::TrackOptions& options = recording.options;
  if (choices.layers == "off")
    options.layers = vision::Layers::off;
  else if (choices.layers == "on")
    options.layers = vision::Layers::on;
  else if (!choices.layers.empty() && choices.layers != "auto")
    throw UsageError(fmt::format("--layers must be auto, on or off, not \"{}\"", choices.layers));
  if (options.layers == vision::Layers::on && options.target.kind == vision::Target::Kind::rectangle)
    throw UsageError("--layers on needs a round disc, and --template follows a rectangle");
}

}  // namespace

Recording recording_of(const std::filesystem::path& video, const TrackChoices& choices) {
  Recording recording;
  recording.video = video;
  if (!choices.config.empty()) apply_config(recording, choices.config);
  apply_frame_rate(choices, recording);
  apply_scale(choices, recording);
  set_chamfer(recording);
  apply_target(choices, recording);
  recording.options.first_frame = choices.first_frame;
  recording.options.last_frame = choices.last_frame;
  recording.options.frame_step = choices.frame_step.value_or(1);
  if (recording.options.frame_step < 1)
    throw UsageError(
        fmt::format("--frames A:B:STEP: the step must be 1 or more, not {}", *choices.frame_step));
  if (choices.first_frame && choices.last_frame && *choices.first_frame > *choices.last_frame)
    throw UsageError(fmt::format("--frames {}:{}: the first frame comes after the last", *choices.first_frame,
                                 *choices.last_frame));
  apply_layers(choices, recording);
  return recording;
}

}  // namespace tribotrack::apps
