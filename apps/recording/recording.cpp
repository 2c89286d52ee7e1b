#include "apps/recording/recording.h"

#include <fmt/format.h>

#include <cmath>
#include <span>
#include <utility>

#include "apps/files/camera.h"
#include "apps/files/campaign/keys.h"
#include "apps/files/run_folder.h"
#include "apps/files/track_file.h"
#include "apps/program/errors.h"
#include "apps/text/strict_toml.h"
#include "apps/usage/commit.h"

namespace tribotrack::apps {

namespace {

/// What is followed, by [part] and [camera].
void set_target(Recording& recording) {
  const CameraSection& camera = recording.camera;
  const PartSection& part = recording.part;
  recording.options.target = is_given(camera.target) ? camera.target : part.target;
  recording.options.marker = camera.marker;
  if (camera.marker_px) recording.options.marker = {vision::MarkerChoice::Kind::circle, *camera.marker_px};
  recording.options.gate = camera.gate_px;
  if (part.chamfer_mm && part.diameter_mm)
    recording.options.chamfer = *part.chamfer_mm / (0.5 * *part.diameter_mm);
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

/// C.toml: [camera] and [part] as in a campaign, [track] min_ncc, max_lost_share.
void apply_config(Recording& recording, const std::string& file) {
  StrictTable top = StrictTable::read(file);
  if (auto table = top.table("part")) recording.part = read_part(*table);
  if (auto table = top.table("camera"))
    recording.camera = read_camera(*table, std::filesystem::path(file).parent_path());
  if (auto track = top.table("track")) {
    recording.options.min_ncc = track->number("min_ncc").value_or(recording.options.min_ncc);
    recording.options.max_lost_share =
        track->not_negative("max_lost_share").value_or(recording.options.max_lost_share);
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
    throw UsageError("--layers must be auto, on or off, not \"{}\"", choices.layers);
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
  recording.options.first_frame = choices.first_frame;
  recording.options.last_frame = choices.last_frame;
  recording.options.frame_step = choices.frame_step.value_or(1);
  if (recording.options.frame_step < 1)
    throw UsageError("--frames A:B:STEP: the step must be 1 or more, not {}", *choices.frame_step);
  if (choices.first_frame && choices.last_frame && *choices.first_frame > *choices.last_frame)
    throw UsageError("--frames {}:{}: the first frame comes after the last", *choices.first_frame,
                     *choices.last_frame);
  apply_layers(choices, recording);
  return recording;
}

namespace {

Json target_json(const vision::Target& target) {
  using Kind = vision::Target::Kind;
  if (target.kind == Kind::disc) return {{"disc_px", circle_json(target.disc)}};
  if (target.kind == Kind::rectangle) return {{"template_px", rect_json(target.rectangle)}};
  return "find the disc";
}

Json configuration_of(const Recording& recording, const std::optional<Input>& calibration) {
  const vision::MarkerChoice& marker = recording.options.marker;
  Json json = {{"frame_rate_hz", optional_json(recording.camera.frame_rate_hz)},
               {"mm_per_px", optional_json(recording.camera.mm_per_px)},
               {"mm_per_px_sd", recording.camera.mm_per_px_sd},
               {"calibration", calibration ? Json(calibration->xxh3_128) : Json()},
               {"diameter_mm", optional_json(recording.part.diameter_mm)},
               {"diameter_sd_mm", recording.part.diameter_sd_mm},
               {"chamfer_mm", optional_json(recording.part.chamfer_mm)},
               {"height_mm", optional_json(recording.part.height_mm)},
               {"working_distance_mm", optional_json(recording.camera.working_distance_mm)},
               {"xi_axis_rad", recording.camera.xi_axis_rad},
               {"target", target_json(recording.options.target)},
               {"marker", marker.kind == vision::MarkerChoice::Kind::circle ? circle_json(marker.circle)
                                                                            : Json(marker_word(marker))},
               {"gate", circle_json(recording.options.gate)},
               {"first_frame", optional_json(recording.options.first_frame)},
               {"last_frame", optional_json(recording.options.last_frame)},
               {"min_ncc", recording.options.min_ncc},
               {"max_lost_share", recording.options.max_lost_share},
               {"row_time_s", recording.camera.row_time_s},
               {"layers", recording.options.layers == vision::Layers::automatic ? "auto"
                          : recording.options.layers == vision::Layers::on      ? "on"
                                                                                : "off"}};
  if (recording.options.frame_step > 1) json["frame_step"] = recording.options.frame_step;
  if (recording.camera.tag_mm) {
    json["tag_mm"] = *recording.camera.tag_mm;
    json["tag_mm_sd"] = recording.camera.tag_mm_sd;
  }
  if (!recording.camera.frame_rate_reason.empty())
    json["frame_rate_reason"] = recording.camera.frame_rate_reason;
  return json;
}

/// A rolling shutter reads a frame within the time of one, and a lamp's row is not the part's.
void require_rows_in_time(const Recording& recording, const vision::SourceInfo& info) {
  if (recording.camera.row_time_s == 0) return;
  const double frame = std::abs(recording.camera.row_time_s) * info.height;
  if (info.time_base.rate_hz && frame * *info.time_base.rate_hz > 1)
    throw InvalidInput(
        "{}: row_time_s = {:.3g} reads a frame of {} rows in {:.3g} s, but frames follow each other "
        "every {:.3g} s; give the time from one row to the next",
        recording.video.string(), recording.camera.row_time_s, info.height, frame,
        1 / *info.time_base.rate_hz);
  if (recording.options.gate)
    throw InvalidInput(
        "{}: a lamp (gate_px) is not timed under a rolling shutter (row_time_s); leave one out and "
        "give phi_rad and dtau_rad as commanded",
        recording.video.string());
}

constexpr double kOtherRate = 0.2;  ///< a rate off by more was not meant for this recording

/// A rate given against what the camera itself says needs a reason.
void require_rate_of_recording(const Recording& recording, const vision::SourceInfo& info) {
  if (!recording.camera.frame_rate_hz || !recording.camera.frame_rate_reason.empty()) return;
  for (const vision::TimeBaseCandidate& said : info.time_base.candidates)
    if ((said.source.starts_with("cine") || said.source.starts_with("sidecar")) && said.rate_hz > 0 &&
        std::abs(*recording.camera.frame_rate_hz / said.rate_hz - 1) > kOtherRate)
      throw InvalidInput(
          "{}: frame_rate_hz = {:.6g} (--fps) is given, but the camera wrote {:.6g} Hz into it ({}); leave "
          "it out, or say how you know: frame_rate_reason = \"TEXT\" (--fps-reason TEXT)",
          recording.video.string(), *recording.camera.frame_rate_hz, said.rate_hz, said.source);
}

/// Players stretch such pictures; a circle in them is an ellipse here, and alpha is no angle.
void require_square_pixels(const Recording& recording, const vision::SourceInfo& info) {
  constexpr double kSquare = 1e-3;
  if (std::abs(info.pixel_aspect - 1) <= kSquare) return;
  throw InvalidInput(
      "{}: its pixels are not square: they are {:.6g} times as wide as high (sample aspect ratio), so "
      "x and y have different scales; scale the pictures first (ffmpeg -i IN -vf "
      "scale=iw*sar:ih,setsar=1 -c:v ffv1 OUT.mkv), or take the ratio out where it is wrong (-vf setsar=1)",
      recording.video.string(), info.pixel_aspect);
}

}  // namespace

Json settings_of(const Recording& recording) {
  return configuration_of(recording, std::nullopt);
}

Recording checked(Recording recording) {
  std::vector<std::filesystem::path> files;
  if (!recording.source) files.push_back(recording.video);
  if (recording.camera.calibration) files.push_back(*recording.camera.calibration);
  recording.state = InputState(files);
  for (const auto& file : files)
    recording.inputs.push_back(file == recording.video ? hashed_recording(file) : hashed_input(file));
  recording.configuration = configuration_of(
      recording, recording.camera.calibration ? std::optional(recording.inputs.back()) : std::nullopt);
  if (!recording.source)
    recording.key =
        hash_of_text(TRIBOTRACK_VERSION + recording.configuration.dump() + recording.inputs[0].xxh3_128);
  return recording;
}

std::optional<std::string> why_outdated(const std::filesystem::path& csv, const Recording& recording) {
  const std::filesystem::path meta = csv.string() + ".meta.json";
  if (!std::filesystem::exists(csv) && !std::filesystem::exists(meta)) return "";
  if (!std::filesystem::exists(csv)) return "its table was gone";
  if (!std::filesystem::exists(meta)) return "its meta file was gone";
  Json json;
  try {
    json = read_json(meta);
    track_described_by(json, meta);  // throws where it is damaged
  } catch (const InvalidInput&) {
    return "its meta file was damaged";
  }
  if (json.value("revision", Json()) != source_revisions().at("track"))
    return "another revision of this program had made it";
  if (json.value("key", Json()) != recording.key) return "its recording or its settings have changed";
  if (json.value("result_xxh3_128", Json()) != hashed_input(csv).xxh3_128)
    return "its table was changed after it was written";
  // Of a large recording a sample is hashed: what was written into it since may lie between.
  if (!recording.inputs.front().hashed.empty())
    for (const std::filesystem::path& file : files_of_input(recording.video))
      if (std::filesystem::last_write_time(file) > std::filesystem::last_write_time(csv))
        return "its recording was written to after it";
  return std::nullopt;
}

void require_trackable(const Recording& recording, const vision::SourceInfo& info) {
  if (!info.time_base.known())
    throw vision::InputError(fmt::format("{}: {}", recording.video.string(), info.time_base.why_unknown()));
  if (!recording.camera.mm_per_px && !recording.camera.calibration && recording.part.diameter_mm &&
      recording.options.target.kind == vision::Target::Kind::rectangle)
    throw UsageError(
        "a template has no diameter to scale by: give --mm-per-px instead of --disc-diameter-mm");
  require_square_pixels(recording, info);
  require_rate_of_recording(recording, info);
  require_rows_in_time(recording, info);
}

}  // namespace tribotrack::apps
