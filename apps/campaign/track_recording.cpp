#include "apps/campaign/track_recording.h"

#include <fmt/format.h>
#include <xxhash.h>

#include "apps/files/calibration_file.h"
#include "apps/files/track_file.h"
#include "apps/program/errors.h"
#include "apps/text/output_file.h"
#include "vision/millimetres.h"

namespace tribotrack::apps {

namespace {

Json circle_json(const vision::Circle& circle) {
  return Json::array({circle.x, circle.y, circle.radius});
}

Json target_json(const vision::Target& target) {
  using Kind = vision::Target::Kind;
  if (target.kind == Kind::disc) return {{"disc_px", circle_json(target.disc)}};
  if (target.kind == Kind::rectangle)
    return {{"template_px", Json::array({target.rectangle.x, target.rectangle.y, target.rectangle.width,
                                         target.rectangle.height})}};
  return "find the disc";
}

Json marker_json(const vision::MarkerChoice& marker) {
  using Kind = vision::MarkerChoice::Kind;
  if (marker.kind == Kind::circle) return circle_json(marker.circle);
  if (marker.kind == Kind::texture) return "texture";
  return marker.kind == Kind::find ? Json("find") : Json("none");
}

std::optional<vision::PlaneGeometry> geometry_of(const RecordingJob& job, const vision::SourceInfo& info,
                                                 const vision::TrackSummary& summary) {
  if (job.calibration) {
    const vision::CameraCalibration camera = read_calibration(*job.calibration);
    if (camera.width != info.width || camera.height != info.height)
      throw InvalidInput(
          fmt::format("{}: is for pictures of {} x {} pixels, but {} has {} x {}; calibrate with the camera "
                      "set as for the "
                      "recording",
                      job.calibration->string(), camera.width, camera.height, job.video.string(), info.width,
                      info.height));
    return vision::PlaneGeometry(camera, job.height_mm.value_or(0));
  }
  std::optional<vision::Parallax> parallax;
  if (job.height_mm && job.working_distance_mm) parallax = {*job.height_mm, *job.working_distance_mm};
  if (job.mm_per_px)
    return vision::PlaneGeometry(vision::given_scale(*job.mm_per_px, job.mm_per_px_sd),
                                 vision::ScalePlane::platform, parallax);
  if (!job.diameter_mm) return std::nullopt;
  return vision::PlaneGeometry(vision::scale_from_diameter(*job.diameter_mm, summary.disc.radius,
                                                           summary.disc_radius_sd, job.diameter_sd_mm),
                               vision::ScalePlane::part_top, parallax);
}

template <class T>
Json optional_json(const std::optional<T>& value) {
  return value ? Json(*value) : Json();
}

}  // namespace

Json RecordingJob::configuration() const {
  return {{"frame_rate_hz", optional_json(frame_rate_hz)},
          {"mm_per_px", optional_json(mm_per_px)},
          {"mm_per_px_sd", mm_per_px_sd},
          {"calibration", calibration ? Json(hash_of_input(*calibration)) : Json()},
          {"diameter_mm", optional_json(diameter_mm)},
          {"diameter_sd_mm", diameter_sd_mm},
          {"height_mm", optional_json(height_mm)},
          {"working_distance_mm", optional_json(working_distance_mm)},
          {"xi_axis_rad", xi_axis_rad},
          {"target", target_json(track.target)},
          {"marker", marker_json(track.marker)},
          {"gate", track.gate ? circle_json(*track.gate) : Json()},
          {"first_frame", optional_json(track.first_frame)},
          {"last_frame", optional_json(track.last_frame)},
          {"min_ncc", track.min_ncc},
          {"max_lost_share", track.max_lost_share},
          {"search_margin_px", track.search_margin_px},
          {"layers", track.layers == vision::Layers::automatic ? "auto"
                     : track.layers == vision::Layers::on      ? "on"
                                                               : "off"}};
}

std::string RecordingJob::key() const {
  const std::string text = TRIBOTRACK_VERSION + configuration().dump() + hash_of_input(video);
  const XXH128_hash_t hash = XXH3_128bits(text.data(), text.size());
  return fmt::format("{:016x}{:016x}", hash.high64, hash.low64);
}

TrackedRecording track_recording(const RecordingJob& job) {
  const auto source = vision::open_source(job.video, {job.frame_rate_hz});
  if (!source->info().time_base.known())
    throw vision::InputError(
        fmt::format("{}: {}", job.video.string(), source->info().time_base.why_unknown()));
  if (!job.mm_per_px && !job.calibration && job.diameter_mm &&
      job.track.target.kind == vision::Target::Kind::rectangle)
    throw UsageError(
        "a template has no diameter to scale by: give --mm-per-px instead of --disc-diameter-mm");
  TrackedRecording recording;
  recording.result = vision::track(*source, job.track);
  recording.info = source->info();
  vision::TrackSummary& summary = recording.result.summary;
  try {
    if (const auto geometry = geometry_of(job, recording.info, summary)) {
      recording.geometry = geometry->as_needed(recording.result.track, summary.limit_px, summary.plan);
      recording.scale = recording.geometry->part_scale();
    }
  } catch (const std::invalid_argument& error) {
    throw InvalidInput(fmt::format("{}: {}", job.video.string(), error.what()));
  } catch (const std::domain_error& error) {
    throw InvalidInput(fmt::format("{}: {}; calibrate with the board in the part's whole range",
                                   job.video.string(), error.what()));
  }
  return recording;
}

Json summary_json(const TrackedRecording& recording) {
  const vision::TrackSummary& s = recording.result.summary;
  Json json = {{"frames", s.frames},
               {"ok", s.ok},
               {"lost", s.lost},
               {"edge", s.edge},
               {"refound", s.refound},
               {"lost_counted", s.lost_counted},
               {"absent_at_first", s.absent_at_first},
               {"left_for_good", s.left_for_good},
               {"gate_passed", s.gate_passed},
               {"disc_px", circle_json(s.disc)},
               {"disc_radius_sd_px", s.disc_radius_sd},
               {"disc_radius_common_sd_px", s.disc_radius_common_sd},
               {"slow_sd_px", s.slow_sd},
               {"slow_time_s", s.slow_time},
               {"disc_blur_px", s.disc_blur},
               {"noise_levels", s.noise_levels},
               {"limit_px", s.limit_px},
               {"frame_rate_hz", optional_json(recording.info.time_base.rate_hz)},
               {"time_base", recording.info.time_base.source},
               {"mm_per_px", recording.scale ? Json(recording.scale->mm_per_px) : Json()},
               {"warnings", s.warnings}};
  if (recording.result.track.has_gate) {
    json["gate_pixels"] = s.gate_pixels;
    json["gate_clipped_share"] = s.gate_clipped_share;
  }
  if (recording.result.track.has_marker) json["marker_px"] = circle_json(s.marker);
  return json;
}

void write_track(const std::filesystem::path& csv, const RecordingJob& job,
                 const TrackedRecording& recording) {
  MetaFile meta;
  meta.command = "track";
  meta.inputs = {job.video};
  if (job.calibration) meta.inputs.push_back(*job.calibration);
  meta.configuration = job.configuration();
  meta.more["key"] = job.key();
  meta.more["time_base"] = json_of(recording.info.time_base);
  meta.more["recording"] = {{"format", recording.info.format},
                            {"codec", recording.info.codec},
                            {"width", recording.info.width},
                            {"height", recording.info.height},
                            {"bits", recording.info.bits},
                            {"frames", recording.info.frame_count},
                            {"first_image", recording.info.first_number},
                            {"exposure_s", optional_json(recording.info.exposure_s)},
                            {"notes", recording.info.notes}};
  meta.more["frame_of_reference"] = recording.result.track.has_marker ? "platform" : "camera";
  if (recording.result.track.has_marker)
    meta.more["platform_seen_by"] = recording.result.summary.texture_patch.width > 0 ? "texture" : "marker";
  meta.more["scale"] = recording.scale
                           ? Json{{"mm_per_px", recording.scale->mm_per_px},
                                  {"mm_per_px_sd", recording.scale->sd},
                                  {"source", recording.scale->source},
                                  {"marker_mm_per_px", recording.geometry->marker_scale().mm_per_px},
                                  {"calibrated_camera", recording.geometry->calibrated()}}
                           : Json();
  meta.more["summary"] = summary_json(recording);
  meta.more["plan"] = json_of(recording.result.summary.plan);
  write_file(csv, track_csv(recording.result.track, recording.geometry, job.xi_axis_rad));
  meta.write_beside(csv);
}

bool is_current(const std::filesystem::path& csv, const std::string& key) {
  const std::filesystem::path meta = csv.string() + ".meta.json";
  if (!std::filesystem::exists(csv) || !std::filesystem::exists(meta)) return false;
  try {
    return read_json(meta).value("key", "") == key;
  } catch (const InvalidInput&) {
    return false;  // half a file from elsewhere: make it anew
  }
}

}  // namespace tribotrack::apps
