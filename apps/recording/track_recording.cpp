#include "apps/recording/track_recording.h"

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <utility>

#include "apps/files/camera.h"
#include "apps/program/errors.h"
#include "apps/text/output_file.h"
#include "vision/frame_sink.h"
#include "vision/overlay.h"

namespace tribotrack::apps {

namespace {

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
  if (marker.kind == Kind::find) return "find";
  if (marker.kind == Kind::tag) return tag_word(marker);
  return marker.kind == Kind::none ? "none" : "texture where the ground moves";
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
  if (job.tag_mm && summary.tag)
    return vision::PlaneGeometry(vision::scale_from_tag(*job.tag_mm, *summary.tag, job.tag_mm_sd),
                                 vision::ScalePlane::platform, parallax);
  if (!job.diameter_mm) return std::nullopt;
  return vision::PlaneGeometry(vision::scale_from_diameter(*job.diameter_mm, summary.disc.radius,
                                                           summary.disc_radius_sd, job.diameter_sd_mm),
                               vision::ScalePlane::part_top, parallax);
}

Json configuration_of(const RecordingJob& job, const std::optional<Input>& calibration) {
  Json json = {{"frame_rate_hz", optional_json(job.frame_rate_hz)},
               {"mm_per_px", optional_json(job.mm_per_px)},
               {"mm_per_px_sd", job.mm_per_px_sd},
               {"calibration", calibration ? Json(calibration->xxh3_128) : Json()},
               {"diameter_mm", optional_json(job.diameter_mm)},
               {"diameter_sd_mm", job.diameter_sd_mm},
               {"height_mm", optional_json(job.height_mm)},
               {"working_distance_mm", optional_json(job.working_distance_mm)},
               {"xi_axis_rad", job.xi_axis_rad},
               {"target", target_json(job.track.target)},
               {"marker", marker_json(job.track.marker)},
               {"gate", circle_json(job.track.gate)},
               {"first_frame", optional_json(job.track.first_frame)},
               {"last_frame", optional_json(job.track.last_frame)},
               {"min_ncc", job.track.min_ncc},
               {"max_lost_share", job.track.max_lost_share},
               {"search_margin_px", job.track.search_margin_px},
               {"row_time_s", job.row_time_s},
               {"layers", job.track.layers == vision::Layers::automatic ? "auto"
                          : job.track.layers == vision::Layers::on      ? "on"
                                                                        : "off"}};
  if (job.tag_mm) {
    json["tag_mm"] = *job.tag_mm;
    json["tag_mm_sd"] = job.tag_mm_sd;
  }
  if (!job.frame_rate_reason.empty()) json["frame_rate_reason"] = job.frame_rate_reason;
  return json;
}

/// The question as the user sees it: what to look at, and what to paste.
[[noreturn]] void ask(vision::FrameSource& source, const vision::AmbiguousTarget& question,
                      const std::optional<std::filesystem::path>& picture) {
  std::string text = fmt::format("{}: ", question.what());
  if (picture) {
    const auto png = vision::numbered_discs_png(source, question.frame, question.discs);
    write_file(*picture, {reinterpret_cast<const char*>(png.data()), png.size()}, Content::pictures);
    text += fmt::format("look at {} and ", picture->string());
  }
  text += "give the part, ";
  const std::string frames = question.first ? "" : fmt::format(" --frames {}:", question.frame);
  for (std::size_t k = 0; k < question.discs.size(); ++k) {
    const vision::Circle& c = question.discs[k];
    text += fmt::format("{}{}: --disc {:.1f},{:.1f},{:.1f}{}", k > 0 ? ", " : "", k + 1, c.x, c.y, c.radius,
                        frames);
  }
  text += question.first ? " (campaign: disc_px = [X, Y, R] in the run)"
                         : fmt::format(" (campaign: disc_px = [X, Y, R], frames = [{}, LAST] in the run)",
                                       question.frame);
  throw AmbiguousPart(text, question);
}

/// A rolling shutter reads a frame within the time of one, and a lamp's row is not the part's.
void require_rows_in_time(const RecordingJob& job, const vision::SourceInfo& info) {
  if (job.row_time_s == 0) return;
  const double frame = std::abs(job.row_time_s) * info.height;
  if (info.time_base.rate_hz && frame * *info.time_base.rate_hz > 1)
    throw InvalidInput(
        fmt::format("{}: row_time_s = {:.3g} reads a frame of {} rows in {:.3g} s, but frames follow each "
                    "other every {:.3g} "
                    "s; give the time from one row to the next",
                    job.video.string(), job.row_time_s, info.height, frame, 1 / *info.time_base.rate_hz));
  if (job.track.gate)
    throw InvalidInput(fmt::format(
        "{}: a lamp (gate_px) is not timed under a rolling shutter (row_time_s); leave one out and "
        "give phi_rad and dtau_rad as commanded",
        job.video.string()));
}

constexpr double kOtherRate = 0.2;  ///< a rate off by more was not meant for this recording

/// A rate given against what the camera itself says needs a reason.
void require_rate_of_recording(const RecordingJob& job, const vision::SourceInfo& info) {
  if (!job.frame_rate_hz || !job.frame_rate_reason.empty()) return;
  for (const vision::TimeBaseCandidate& said : info.time_base.candidates)
    if (said.source.starts_with("cine") && said.rate_hz > 0 &&
        std::abs(*job.frame_rate_hz / said.rate_hz - 1) > kOtherRate)
      throw InvalidInput(fmt::format(
          "{}: frame_rate_hz = {:.6g} (--fps) is given, but the camera wrote {:.6g} Hz into it ({}); leave "
          "it out, or say how you know: frame_rate_reason = \"TEXT\" (--fps-reason TEXT)",
          job.video.string(), *job.frame_rate_hz, said.rate_hz, said.source));
}

/// A mark is found again in most frames, as the part is.
void require_mark(const RecordingJob& job, const vision::Track& track) {
  if (job.track.marker.kind != vision::MarkerChoice::Kind::circle) return;
  const vision::Circle& mark = job.track.marker.circle;
  const auto seen =
      std::ranges::count_if(track.points, [](const auto& point) { return point.marker.has_value(); });
  const auto frames = std::ssize(track.points);
  if (2 * seen < frames)
    throw InvalidInput(
        fmt::format("{}: no mark can be followed at marker_px = [{:.4g}, {:.4g}, {:.4g}] (--marker): it was "
                    "found in {} of {} "
                    "frames; give the place of a mark in the first analysed frame, or leave it out",
                    job.video.string(), mark.x, mark.y, mark.radius, seen, frames));
}

/// A part that passes over the lamp is what blinks there.
void drop_covered_lamp(const RecordingJob& job, vision::TrackResult& result) {
  if (!job.track.gate || !result.track.has_gate) return;
  const vision::Circle& lamp = *job.track.gate;
  const double reach = lamp.radius + result.summary.disc.radius;
  const auto covered = std::ranges::count_if(result.track.points, [&](const vision::TrackPoint& point) {
    return point.status == vision::TrackStatus::ok && std::hypot(point.x - lamp.x, point.y - lamp.y) < reach;
  });
  if (covered == 0) return;
  result.track.has_gate = false;
  for (vision::TrackPoint& point : result.track.points) point.gate.reset();
  result.summary.warnings.push_back(fmt::format(
      "the part covers the lamp at gate_px = [{:.4g}, {:.4g}, {:.4g}] in {} of {} frames: the lamp is not "
      "read, phi and dtau are taken as commanded; correct gate_px",
      lamp.x, lamp.y, lamp.radius, covered, result.track.points.size()));
}

}  // namespace

std::filesystem::path question_picture(const std::filesystem::path& beside,
                                       const std::filesystem::path& recording) {
  std::filesystem::path name = beside.empty() || is_standard_output(beside) ? recording.filename() : beside;
  if (name.empty()) name = recording.parent_path().filename();  // a folder's name with a slash
  return name.replace_extension(".discs.png");
}

Json settings_of(const RecordingJob& job) {
  return configuration_of(job, std::nullopt);
}

PreparedJob prepare(RecordingJob job) {
  PreparedJob prepared;
  std::vector<std::filesystem::path> files = {job.video};
  if (job.calibration) files.push_back(*job.calibration);
  const auto begun = std::chrono::steady_clock::now();
  prepared.state = InputState(files);
  prepared.inputs.push_back(hashed_recording(job.video));
  if (job.calibration) prepared.inputs.push_back(hashed_input(*job.calibration));
  prepared.hashing_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
  prepared.configuration =
      configuration_of(job, job.calibration ? std::optional(prepared.inputs[1]) : std::nullopt);
  prepared.key =
      hash_of_text(TRIBOTRACK_VERSION + prepared.configuration.dump() + prepared.inputs[0].xxh3_128);
  prepared.job = std::move(job);
  return prepared;
}

PreparedJob prepare_in_memory(RecordingJob job) {
  PreparedJob prepared;
  if (job.calibration) {
    prepared.state = InputState({*job.calibration});
    prepared.inputs.push_back(hashed_input(*job.calibration));
  }
  prepared.configuration =
      configuration_of(job, job.calibration ? std::optional(prepared.inputs[0]) : std::nullopt);
  prepared.job = std::move(job);
  return prepared;
}

namespace {

TrackedRecording track_source(const PreparedJob& prepared, std::unique_ptr<vision::FrameSource> source,
                              const std::optional<std::filesystem::path>& picture) {
  const RecordingJob& job = prepared.job;
  TrackedRecording recording;
  recording.source = std::move(source);
  const vision::SourceInfo& info = recording.info();
  if (!info.time_base.known())
    throw vision::InputError(fmt::format("{}: {}", job.video.string(), info.time_base.why_unknown()));
  if (!job.mm_per_px && !job.calibration && job.diameter_mm &&
      job.track.target.kind == vision::Target::Kind::rectangle)
    throw UsageError(
        "a template has no diameter to scale by: give --mm-per-px instead of --disc-diameter-mm");
  require_rate_of_recording(job, info);
  require_rows_in_time(job, info);
  try {
    recording.result = vision::track(*recording.source, job.track);
  } catch (const vision::AmbiguousTarget& question) {
    ask(*recording.source, question, picture);
  }
  require_mark(job, recording.result.track);
  drop_covered_lamp(job, recording.result);
  auto& times = recording.result.stage_times;
  times.insert(times.begin(), {"hashing the inputs", prepared.hashing_s});
  if (job.row_time_s != 0)
    vision::shift_to_rows(recording.result.track, job.row_time_s, 0.5 * (info.height - 1));
  prepared.state.require_unchanged();
  vision::TrackSummary& summary = recording.result.summary;
  try {
    if (const auto geometry = geometry_of(job, info, summary)) {
      recording.geometry = geometry->as_needed(recording.result.track, summary.limit_px, summary.plan);
      recording.scale = recording.geometry->part_scale();
    }
    recording.rows = track_rows(recording.result.track, recording.geometry, job.xi_axis_rad);
  } catch (const std::invalid_argument& error) {
    throw InvalidInput(fmt::format("{}: {}", job.video.string(), error.what()));
  } catch (const std::domain_error& error) {
    throw InvalidInput(fmt::format("{}: {}; calibrate with the board in the part's whole range",
                                   job.video.string(), error.what()));
  }
  return recording;
}

}  // namespace

TrackedRecording track_recording(const PreparedJob& prepared,
                                 const std::optional<std::filesystem::path>& beside) {
  const RecordingJob& job = prepared.job;
  std::optional<std::filesystem::path> picture;
  if (beside) picture = question_picture(*beside, job.video);
  return track_source(prepared, vision::open_source(job.video, {job.frame_rate_hz, job.frame_rate_reason}),
                      picture);
}

TrackedRecording track_recording(const PreparedJob& prepared, std::unique_ptr<vision::FrameSource> source) {
  return track_source(prepared, std::move(source), std::nullopt);
}

Track track_of(const PreparedJob& prepared, const TrackedRecording& recording) {
  const std::filesystem::path& video = prepared.job.video;
  return with_rows(track_described_by(meta_of(prepared, recording).json(), video), recording.rows, video);
}

void write_overlay_file(const std::filesystem::path& path, const TrackedRecording& recording) {
  require_writable(path, Content::pictures);
  try {
    vision::write_overlay(*recording.source, recording.result, path);
  } catch (const vision::OutputError& error) {
    throw OutputError(error.what());
  }
}

std::string gate_failure(const RecordingJob& job, const vision::TrackSummary& summary) {
  if (summary.rests_for_ever)
    return fmt::format(
        "{}: the disc that was found by itself never moves: give the part with --disc X,Y,R; should it be "
        "this one, --disc {:.1f},{:.1f},{:.1f}",
        job.video.string(), summary.disc.x, summary.disc.y, summary.disc.radius);
  if (!summary.gate_passed)
    return fmt::format(
        "{}: the part was lost in {} of {} frames, more than the allowed share {}; look at --overlay, give "
        "--disc, or leave frames out with --frames",
        job.video.string(), summary.lost_counted, summary.frames, job.track.max_lost_share);
  return {};
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
               {"rests_for_ever", s.rests_for_ever},
               {"disc_px", circle_json(s.disc)},
               {"disc_radius_sd_px", s.disc_radius_sd},
               {"disc_radius_common_sd_px", s.disc_radius_common_sd},
               {"slow_sd_px", s.slow_sd()},
               {"slow_time_s", s.slow_time()},
               {"audit", json_of(s.audit)},
               {"disc_blur_px", s.disc_blur},
               {"noise_levels", s.noise_levels},
               {"limit_px", s.limit_px},
               {"frame_rate_hz", optional_json(recording.info().time_base.rate_hz)},
               {"time_base", recording.info().time_base.source},
               {"mm_per_px", recording.scale ? Json(recording.scale->mm_per_px) : Json()},
               {"warnings", s.warnings}};
  if (recording.result.track.has_gate) {
    json["gate_pixels"] = s.gate_pixels;
    json["gate_clipped_share"] = s.gate_clipped_share;
  }
  if (s.marker.radius > 0) json["marker_px"] = circle_json(s.marker);
  return json;
}

MetaFile meta_of(const PreparedJob& prepared, const TrackedRecording& recording) {
  MetaFile meta;
  meta.command = "track";
  meta.inputs = prepared.inputs;
  meta.configuration = prepared.configuration;
  if (!prepared.key.empty()) meta.more["key"] = prepared.key;
  meta.more["time_base"] = json_of(recording.info().time_base);
  meta.more["recording"] = {{"format", recording.info().format},
                            {"codec", recording.info().codec},
                            {"width", recording.info().width},
                            {"height", recording.info().height},
                            {"bits", recording.info().bits},
                            {"frames", recording.info().frame_count},
                            {"first_image", recording.info().first_number},
                            {"exposure_s", optional_json(recording.info().exposure_s)},
                            {"trigger_time", recording.info().trigger_time},
                            {"notes", recording.info().notes}};
  meta.more["frame_of_reference"] = recording.result.track.has_marker ? "platform" : "camera";
  if (recording.result.track.has_marker)
    meta.more["platform_seen_by"] = recording.result.summary.ground_is_marker ? "texture" : "marker";
  meta.more["scale"] = recording.scale
                           ? Json{{"mm_per_px", recording.scale->mm_per_px},
                                  {"mm_per_px_sd", recording.scale->sd},
                                  {"source", recording.scale->source},
                                  {"marker_mm_per_px", recording.geometry->marker_scale().mm_per_px},
                                  {"calibrated_camera", recording.geometry->calibrated()}}
                           : Json();
  meta.more["summary"] = summary_json(recording);
  meta.more["slow_errors"] = json_of(recording.result.summary.slow);
  meta.more["audit"] = json_of(recording.result.summary.audit);
  if (recording.result.summary.coded) meta.more["coding"] = json_of(*recording.result.summary.coded);
  meta.more["plan"] = json_of(recording.result.summary.plan);
  return meta;
}

Input write_track(const std::filesystem::path& csv, const PreparedJob& prepared,
                  const TrackedRecording& recording) {
  const std::string table = track_csv(recording.rows);
  write_result(csv, table, meta_of(prepared, recording));
  return hashed_input(csv, table);
}

bool is_current(const std::filesystem::path& csv, const std::string& key) {
  const std::filesystem::path meta = csv.string() + ".meta.json";
  if (!std::filesystem::exists(csv) || !std::filesystem::exists(meta)) return false;
  try {
    const Json json = read_json(meta);
    track_described_by(json, meta);  // throws where it is damaged
    return json.value("key", Json()) == key;
  } catch (const InvalidInput&) {
    return false;  // damaged, or not ours: track again
  }
}

}  // namespace tribotrack::apps
