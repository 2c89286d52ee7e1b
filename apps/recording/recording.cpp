#include "apps/recording/recording.h"

#include <fmt/format.h>

#include <span>

#include "apps/files/camera.h"
#include "apps/files/campaign/keys.h"
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
  const CameraSection& camera = recording.camera;
  recording.options.target = is_given(camera.target) ? camera.target : recording.part.target;
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
  if (is_given(run.target)) camera.target = run.target;
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

/// C.toml: [camera] and [part] as in a campaign, [track] min_ncc, max_lost_share, search_margin_px.
void apply_config(Recording& recording, const std::string& file) {
  StrictTable top = StrictTable::read(file);
  if (auto table = top.table("part")) recording.part = read_part(*table);
  if (auto table = top.table("camera"))
    recording.camera = read_camera(*table, std::filesystem::path(file).parent_path());
  if (auto track = top.table("track")) {
    recording.options.min_ncc = track->number("min_ncc").value_or(recording.options.min_ncc);
    recording.options.max_lost_share =
        track->not_negative("max_lost_share").value_or(recording.options.max_lost_share);
    recording.options.search_margin_px = static_cast<int>(track->integer("search_margin_px").value_or(0));
    track->finish();
  }
  top.finish();
}

/// What the flags give takes the place of what --config holds.
void make_room(const TrackChoices& choices, Recording& recording) {
  CameraSection& camera = recording.camera;
  PartSection& part = recording.part;
  const Json &of_camera = choices.keys.at("camera"), &of_part = choices.keys.at("part");
  if (of_camera.contains("mm_per_px") || of_camera.contains("tag_mm") || of_part.contains("diameter_mm") ||
      !choices.calibration.empty()) {
    camera.mm_per_px.reset();
    camera.mm_per_px_sd = 0;
    camera.calibration.reset();
    camera.tag_mm.reset();
  }
  if (of_part.contains("diameter_mm")) part.diameter_sd_mm = 0;
  if (of_camera.contains("frame_rate_hz")) camera.frame_rate_reason.clear();
  if (of_camera.contains("marker") || of_camera.contains("marker_px")) {
    camera.marker_px.reset();
    camera.marker = {};
  }
}

/// Of a key, what is wrong is said of its flag.
[[noreturn]] void refuse_flag(std::string message) {
  message.erase(0, message.find('`'));
  for (const auto& flags :
       {std::span<const TrackFlag>(kTrackNumbers), std::span<const TrackFlag>(kTrackPlaces)})
    for (const TrackFlag& flag : flags) {
      const std::string key = fmt::format("`{}`", flag.key);
      for (auto at = message.find(key); at != message.npos; at = message.find(key))
        message.replace(at, key.size(), flag.flag);
    }
  throw UsageError(message);
}

void apply_keys(const TrackChoices& choices, Recording& recording) {
  make_room(choices, recording);
  try {
    StrictTable camera = StrictTable::of(choices.keys.at("camera"), "");
    StrictTable part = StrictTable::of(choices.keys.at("part"), "");
    read_keys(camera, camera_keys(), recording.camera);
    read_keys(part, part_keys(), recording.part);
    if (!choices.calibration.empty()) recording.camera.calibration = choices.calibration;
    if (part.has("chamfer_mm") && !recording.part.diameter_mm)
      part.fail("chamfer_mm", "needs --disc-diameter-mm");
    check_camera(camera, recording.camera);
    check_part(part, recording.part);
  } catch (const InvalidInput& error) {
    refuse_flag(error.what());
  }
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
  apply_keys(choices, recording);
  set_target(recording);
  set_chamfer(recording);
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
