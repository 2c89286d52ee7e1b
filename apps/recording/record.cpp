#include "apps/recording/record.h"

#include <fmt/format.h>

#include "apps/program/errors.h"
#include "apps/text/output_file.h"
#include "apps/usage/commit.h"
#include "vision/frame_sink.h"
#include "vision/overlay.h"

namespace tribotrack::apps {

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
