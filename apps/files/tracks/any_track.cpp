#include "apps/files/tracks/any_track.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "apps/files/meta_file.h"
#include "apps/files/tracks/foreign_track.h"
#include "apps/program/errors.h"
#include "apps/text/csv_table.h"
#include "apps/text/output_file.h"
#include "apps/text/strict_toml.h"

namespace tribotrack::apps {

namespace fs = std::filesystem;

namespace {

fs::path meta_of(const fs::path& path) {
  return path.string() + ".meta.json";
}

bool is_ours(const fs::path& path, const std::string& text) {
  if (fs::exists(meta_of(path))) return true;
  CsvTable table(path, text.substr(0, text.find('\n')));
  return table.next() && std::ranges::count(table.cells(), "status") > 0;
}

/// What results of numpy and pickles begin with.
void require_text(const fs::path& path, const std::string& text) {
  if (text.find('\0') == std::string::npos && !text.starts_with('\x80')) return;
  throw InvalidInput(fmt::format(
      "{}: is no table but a binary file{}", path.string(),
      path.extension() == ".npy" || path.extension() == ".pkl"
          ? ": write one of pyidi's points as text, with d = displacements[point]: "
            "numpy.savetxt(\"x.csv\", numpy.c_[numpy.arange(len(d)), d[:, 1], d[:, 0]], delimiter=\",\", "
            "header=\"frame,x_px,y_px\", comments=\"\")"
          : "; if it is a recording, give it as `video`, or `tribotrack track` makes a track of it"));
}

/// A folder, or nothing at all, is refused as a track of ours is.
std::string text_of_track(const fs::path& path) {
  if (!fs::is_regular_file(path)) read_track_file(path);
  std::string text = read_text(path);
  require_text(path, text);
  return text;
}

Json meta_json(const ForeignTrack& track) {
  const TrackFacts& facts = track.facts;
  const auto lost = std::ranges::count(track.rows.rows, vision::TrackStatus::lost, &TrackRow::status);
  Json json;
  json["imported"] = {{"layout", track.layout}, {"reading", facts.imported}};
  json["time_base"] = {{"rate_hz", optional_json(facts.frame_rate_hz)}, {"source", facts.time_base}};
  json["frame_of_reference"] = facts.in_camera_frame ? "camera" : "platform";
  if (!facts.in_camera_frame) json["platform_seen_by"] = "marker";
  json["scale"] = facts.mm_per_px ? Json{{"mm_per_px", *facts.mm_per_px},
                                         {"mm_per_px_sd", facts.mm_per_px_sd.value_or(0)},
                                         {"source", facts.scale_source}}
                                  : Json();
  json["summary"] = {{"frames", facts.frames},
                     {"ok", facts.frames - lost},
                     {"lost", lost},
                     {"gate_passed", true},
                     {"sd_from_scatter", facts.sd_from_scatter},
                     {"warnings", facts.warnings}};
  return json;
}

}  // namespace

TrackFile read_any_track(const fs::path& path, const TrackReading& reading) {
  std::string text = text_of_track(path);
  if (is_ours(path, text)) return read_track_file(path);
  Input input = hashed_input(path, text);
  ForeignTrack track = read_foreign_track(path, std::move(text), reading);
  track.facts.recorded_in = {input};
  TrackFile file = track_file_of(track.rows, track.facts, path);
  file.inputs = {std::move(input)};
  return file;
}

TrackFile import_track(const fs::path& path, const TrackReading& reading, const fs::path& csv) {
  std::string text = text_of_track(path);
  if (is_ours(path, text)) {
    TrackFile file = read_track_file(path);  // first: what cannot be read is not copied
    write_file(csv, text);
    if (fs::exists(meta_of(path)))
      write_file(meta_of(csv), read_text(meta_of(path)));
    else
      fs::remove(meta_of(csv));
    file.inputs = {hashed_input(csv, text)};
    return file;
  }
  MetaFile meta;
  meta.command = "track";
  meta.inputs = {hashed_input(path, text)};
  ForeignTrack track = read_foreign_track(path, std::move(text), reading);
  track.facts.recorded_in = meta.inputs;
  meta.configuration = {{"xi_axis_rad", reading.xi_axis_rad},
                        {"frame_rate_hz", optional_json(reading.frame_rate_hz)},
                        {"mm_per_px", optional_json(reading.mm_per_px)},
                        {"unit", reading.unit},
                        {"point", reading.point},
                        {"mark", reading.mark}};
  meta.more = meta_json(track);
  const std::string table = track_csv(track.rows);
  write_result(csv, table, meta);
  TrackFile file = track_file_of(track.rows, track.facts, path);
  file.inputs = {hashed_input(csv, table)};
  return file;
}

}  // namespace tribotrack::apps
