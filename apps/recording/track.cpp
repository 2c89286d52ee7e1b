#include "apps/recording/track.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "apps/files/camera.h"
#include "apps/program/errors.h"
#include "apps/text/output_file.h"
#include "apps/usage/commit.h"
#include "vision/frame_sink.h"
#include "vision/overlay.h"
#include "vision/survey.h"

namespace tribotrack::apps {

namespace {

constexpr double kWorthSaying = 2e-3;  ///< of the scale: what a caliper leaves of a part of some mm
constexpr double kCaliper = 0.02;      ///< mm
constexpr double kContradicts = 3;     ///< standard deviations

std::optional<vision::PlaneGeometry> geometry_of(const Recording& recording, const vision::SourceInfo& info,
                                                 const vision::TrackSummary& summary) {
  if (recording.camera.calibration) {
    const vision::CameraCalibration camera = read_calibration(*recording.camera.calibration);
    if (camera.width != info.width || camera.height != info.height)
      throw InvalidInput(
          "{}: is for pictures of {} x {} pixels, but {} has {} x {}; calibrate with the "
          "camera set as for the recording",
          recording.camera.calibration->string(), camera.width, camera.height, recording.video.string(),
          info.width, info.height);
    return vision::PlaneGeometry(camera, recording.part.height_mm.value_or(0));
  }
  std::optional<vision::Parallax> parallax;
  if (recording.part.height_mm && recording.camera.working_distance_mm)
    parallax = {*recording.part.height_mm, *recording.camera.working_distance_mm};
  if (recording.camera.mm_per_px)
    return vision::PlaneGeometry(
        vision::given_scale(*recording.camera.mm_per_px, recording.camera.mm_per_px_sd),
        vision::ScalePlane::platform, parallax);
  if (recording.camera.tag_mm && summary.tag)
    return vision::PlaneGeometry(
        vision::scale_from_tag(*recording.camera.tag_mm, *summary.tag, recording.camera.tag_mm_sd),
        vision::ScalePlane::platform, parallax);
  if (!recording.part.diameter_mm) return std::nullopt;
  return vision::PlaneGeometry(
      vision::scale_from_diameter(*recording.part.diameter_mm, summary.outer_radius, summary.outer_radius_sd,
                                  recording.part.diameter_sd_mm),
      vision::ScalePlane::part_top, parallax);
}

/// What the scale by the diameter rests on, or what a diameter beside another scale says of that.
std::optional<std::string> diameter_warning(const Recording& recording, const vision::TrackSummary& summary) {
  const PartSection& part = recording.part;
  if (!part.diameter_mm || !recording.scale || !(summary.disc_blur > 0)) return std::nullopt;
  const double rim = summary.outer_radius_sd / summary.outer_radius;
  const bool by_diameter = !recording.camera.mm_per_px && !recording.camera.calibration &&
                           !(recording.camera.tag_mm && summary.tag);
  if (by_diameter && !summary.chamfer_known && rim > kWorthSaying)
    return fmt::format(
        "the scale by the diameter is known to {:.2g} % only: a chamfer of up to {:.2f} px as dark as the "
        "ground would not show; give chamfer_mm in [part] (--chamfer-mm; 0: a sharp edge), or the scale by "
        "mm_per_px, a tag or a calibration",
        100 * rim, summary.chamfer);
  if (by_diameter) return std::nullopt;
  const double seen = 2 * summary.outer_radius * recording.scale->mm_per_px;
  const double sd = std::hypot(seen * std::hypot(rim, recording.scale->sd / recording.scale->mm_per_px),
                               part.diameter_sd_mm, kCaliper);
  if (std::abs(seen - *part.diameter_mm) < kContradicts * sd) return std::nullopt;
  return fmt::format(
      "the part is {:.4g} mm across by the scale given, sd {:.2g}, not {:.4g} mm: mend the one "
      "or the other",
      seen, sd, *part.diameter_mm);
}

/// The question as the user sees it: what to look at, and what to paste.
[[noreturn]] void ask(vision::FrameSource& source, const vision::AmbiguousTarget& question,
                      const std::optional<std::filesystem::path>& picture) {
  std::string text = fmt::format("{}: ", question.what());
  if (picture) {
    vision::Survey seen;
    seen.frame = question.frame;
    for (const vision::Circle& disc : question.discs)
      seen.discs.push_back({.circle = disc, .role = vision::DiscRole::part});
    const auto png = vision::survey_png(source, seen);
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

/// A mark is found again in most frames, as the part is.
void require_mark(const Recording& recording, const vision::Track& track) {
  if (recording.options.marker.kind != vision::MarkerChoice::Kind::circle) return;
  const vision::Circle& mark = recording.options.marker.circle;
  const auto seen =
      std::ranges::count_if(track.points, [](const auto& point) { return point.marker.has_value(); });
  const auto frames = std::ranges::count_if(
      track.points, [](const auto& point) { return point.status != vision::TrackStatus::repeat; });
  if (2 * seen < frames)
    throw InvalidInput(
        "{}: no mark can be followed at marker_px = [{:.4g}, {:.4g}, {:.4g}] (--marker): it was found "
        "in {} of {} frames; give the place of a mark in the first analysed frame, or leave it out",
        recording.video.string(), mark.x, mark.y, mark.radius, seen, frames);
}

/// A part that passes over the lamp is what blinks there.
void drop_covered_lamp(const Recording& recording, vision::TrackResult& result) {
  if (!recording.options.gate || !result.track.has_gate) return;
  const vision::Circle& lamp = *recording.options.gate;
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

/// OUT/x.csv -> OUT/x.discs.png; of standard output, x.discs.png for a recording x.mp4.
std::filesystem::path question_picture(const std::filesystem::path& beside,
                                       const std::filesystem::path& recording) {
  std::filesystem::path name = beside.empty() || is_standard_output(beside) ? recording.filename() : beside;
  if (name.empty()) name = recording.parent_path().filename();  // a folder's name with a slash
  return name.replace_extension(".discs.png");
}

}  // namespace

Recording tracked(Recording recording, const std::optional<std::filesystem::path>& beside) {
  std::optional<std::filesystem::path> picture;
  if (beside) picture = question_picture(*beside, recording.video);
  if (!recording.source)
    recording.source = vision::open_source(
        recording.video, {recording.camera.frame_rate_hz, recording.camera.frame_rate_reason});
  const vision::SourceInfo& info = recording.info();
  require_trackable(recording, info);
  vision::TrackResult& result = recording.result;
  try {
    result = vision::track(*recording.source, recording.options);
  } catch (const vision::AmbiguousTarget& question) {
    ask(*recording.source, question, picture);
  }
  require_mark(recording, result.track);
  drop_covered_lamp(recording, result);
  if (recording.camera.row_time_s != 0)
    vision::shift_to_rows(result.track, recording.camera.row_time_s, 0.5 * (info.height - 1));
  recording.state.require_unchanged();
  try {
    if ((recording.geometry = geometry_of(recording, info, result.summary))) {
      if (recording.geometry->calibrated())
        result.summary.plan.push_back({"lens and tilt", true, "a calibrated camera was given"});
      else if (!recording.geometry->plain())
        result.summary.plan.push_back({"parallax", true, "a height of the part's top was given"});
      recording.scale = recording.geometry->part_scale();
      if (auto warning = diameter_warning(recording, result.summary))
        result.summary.warnings.push_back(std::move(*warning));
    }
    recording.rows = track_rows(result.track, recording.geometry, recording.camera.xi_axis_rad);
  } catch (const std::invalid_argument& error) {
    throw InvalidInput("{}: {}", recording.video.string(), error.what());
  } catch (const std::domain_error& error) {
    throw InvalidInput("{}: {}; calibrate with the board in the part's whole range", recording.video.string(),
                       error.what());
  }
  return recording;
}

Json summary_json(const Recording& recording) {
  const vision::TrackSummary& s = recording.result.summary;
  Json json = {{"frames", s.frames},
               {"ok", s.ok},
               {"lost", s.lost},
               {"edge", s.edge},
               {"repeat", s.repeats},
               {"refound", s.refound},
               {"lost_counted", s.lost_counted},
               {"absent_at_first", s.absent_at_first},
               {"left_for_good", s.left_for_good},
               {"gate_passed", s.gate_passed},
               {"rests_for_ever", s.rests_for_ever},
               {"disc_px", circle_json(vision::Circle{s.disc.x, s.disc.y, s.outer_radius})},
               {"disc_radius_sd_px", s.outer_radius_sd},
               {"disc_radius_common_sd_px", s.outer_radius_common_sd},
               {"edge_px", s.disc.radius > 0 ? Json(s.disc.radius) : Json()},
               {"edge_sd_px", s.disc_radius_sd},
               {"R_px", s.outer_radius > 0 ? Json(s.outer_radius) : Json()},
               {"chamfer_px", s.chamfer_known ? Json(s.chamfer) : Json()},
               {"blur_px", s.disc_blur},
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

MetaFile meta_of(const Recording& recording) {
  MetaFile meta;
  meta.command = "track";
  meta.inputs = recording.inputs;
  meta.configuration = recording.configuration;
  if (!recording.key.empty()) {
    meta.more["key"] = recording.key;
    meta.more["revision"] = source_revisions().at("track");
  }
  std::vector<std::int64_t> repeats;
  for (const vision::TrackPoint& point : recording.result.track.points)
    if (point.status == vision::TrackStatus::repeat) repeats.push_back(point.frame);
  meta.more["time_base"] = json_of(recording.info(), repeats, false);
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
    meta.more["platform_seen_by"] = recording.result.summary.ground_steps ? "texture" : "marker";
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

Track track_in(const Recording& recording) {
  Track track = with_rows(track_described_by(meta_of(recording).json(), recording.video), recording.rows,
                          recording.video);
  track.inputs = recording.inputs;
  return track;
}

Input write_track(const std::filesystem::path& csv, const Recording& recording) {
  const std::string table = track_csv(recording.rows);
  write_result(csv, table, meta_of(recording));
  return hashed_input(csv, table);
}

void write_overlay_file(const std::filesystem::path& path, const Recording& recording) {
  require_writable(path, Content::pictures);
  try {
    vision::write_overlay(*recording.source, recording.result, path);
  } catch (const vision::OutputError& error) {
    throw OutputError(error.what());
  }
}

void write_first_frame(const std::filesystem::path& picture, const Recording& recording) {
  const auto jpeg = vision::first_frame_jpeg(*recording.source, recording.result.track.first_seen());
  write_file(picture, {reinterpret_cast<const char*>(jpeg.data()), jpeg.size()}, Content::pictures);
}

std::string gate_failure(const Recording& recording) {
  const vision::TrackSummary& summary = recording.result.summary;
  if (summary.rests_for_ever)
    return fmt::format(
        "{}: the disc that was found by itself never moves: give the part with --disc X,Y,R; should it be "
        "this one, --disc {:.1f},{:.1f},{:.1f}",
        recording.video.string(), summary.disc.x, summary.disc.y, summary.disc.radius);
  if (!summary.gate_passed)
    return fmt::format(
        "{}: the part was lost in {} of {} frames, more than the allowed share {}; look at --overlay, give "
        "--disc, or leave frames out with --frames",
        recording.video.string(), summary.lost_counted, summary.frames, recording.options.max_lost_share);
  return {};
}

}  // namespace tribotrack::apps
