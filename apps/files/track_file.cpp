#include "apps/files/track_file.h"

#include <Eigen/Geometry>
#include <cmath>

#include "apps/files/run_folder.h"
#include "apps/program/errors.h"
#include "apps/text/json.h"
#include "apps/text/strict_toml.h"

namespace tribotrack::apps {

namespace {

constexpr double kClippedShare = 0.02;  ///< of the lamp's pixels: above it its brightness is not linear

Eigen::Matrix2d covariance_of(double sd_x, double sd_y, double correlation) {
  const double off = correlation * sd_x * sd_y;
  return (Eigen::Matrix2d() << sd_x * sd_x, off, off, sd_y * sd_y).finished();
}

/// The measured rows of a track as the fit's table.
class FitTable {
 public:
  FitTable(const TrackRows& rows, const Track& track, const std::filesystem::path& path)
      : rows_(rows), track_(track), path_(path) {
    const Eigen::Matrix2d up = Eigen::Vector2d(1, -1).asDiagonal();
    if (track.mm_per_px)
      axes_ = *track.mm_per_px * 1e-3 * Eigen::Rotation2Dd(-track.xi_axis_rad).toRotationMatrix() * up;
  }

  void add(const TrackRow& row, fit::TrackTable& table) const {
    table.frame.push_back(row.frame);
    table.time.push_back(row.time_s);
    table.position.emplace_back(row.x_mm * 1e-3, present(row, row.y_mm, "y_mm") * 1e-3);
    table.covariance.push_back(covariance(row));
    if (rows_.has_rotation) {
      table.angle.push_back(row.theta_rad);
      table.angle_sigma.push_back(std::isnan(row.theta_rad)
                                      ? row.sigma_theta_rad
                                      : positive(row, row.sigma_theta_rad, "sigma_theta_rad"));
    }
    if (rows_.has_marker && rows_.has_planes) {
      table.marker.push_back(1e-3 * Eigen::Vector2d(present(row, row.marker_x_mm, "marker_x_mm"),
                                                    present(row, row.marker_y_mm, "marker_y_mm")));
      table.marker_sigma.push_back(present(row, row.marker_sigma_mm, "marker_sigma_mm") * 1e-3);
    } else if (rows_.has_marker && track_.mm_per_px) {
      table.marker.push_back(axes_ * Eigen::Vector2d(present(row, row.marker_x_px, "marker_x_px"),
                                                     present(row, row.marker_y_px, "marker_y_px")));
      table.marker_sigma.push_back(present(row, row.marker_sigma_px, "marker_sigma_px") * *track_.mm_per_px *
                                   1e-3);
    }
  }

 private:
  /// Where both planes share one scale, the table's mm columns hold no correlation: it stands in pixels.
  Eigen::Matrix2d covariance(const TrackRow& row) const {
    if (rows_.has_planes)
      return covariance_of(present(row, row.sigma_x_mm, "sigma_x_mm") * 1e-3,
                           present(row, row.sigma_y_mm, "sigma_y_mm") * 1e-3,
                           present(row, row.rho_xy_mm, "rho_xy_mm"));
    const double rho_px = std::isnan(row.rho_xy) ? 0 : row.rho_xy;
    if (track_.mm_per_px && !std::isnan(row.sigma_x_px) && !std::isnan(row.sigma_y_px)) {
      const double marker_px = std::isnan(row.marker_sigma_px) ? 0 : row.marker_sigma_px;
      return axes_ * covariance_of(row.sigma_x_px, row.sigma_y_px, rho_px) * axes_.transpose() +
             std::pow(marker_px * *track_.mm_per_px * 1e-3, 2) * Eigen::Matrix2d::Identity();
    }
    return covariance_of(present(row, row.sigma_x_mm, "sigma_x_mm") * 1e-3,
                         present(row, row.sigma_y_mm, "sigma_y_mm") * 1e-3, -rho_px);
  }
  double present(const TrackRow& row, double value, const char* column) const {
    if (std::isnan(value))
      throw InvalidInput("{}: frame {} is ok and has x_mm, but no number in column {}", path_.string(),
                         row.frame, column);
    return value;
  }

  double positive(const TrackRow& row, double value, const char* column) const {
    if (value > 0) return value;
    throw InvalidInput("{}: frame {} has theta_rad, but no positive number in column {}", path_.string(),
                       row.frame, column);
  }

  const TrackRows& rows_;
  const Track& track_;
  const std::filesystem::path& path_;
  /// Takes camera pixels (y down) to metres in campaign axes (y up, turned by -xi_axis).
  Eigen::Matrix2d axes_ = Eigen::Matrix2d::Identity();
};

std::optional<double> number_at(const JsonPlace& place, const char* key) {
  const auto found = place.find(key);
  return found ? std::optional(found->number()) : std::nullopt;
}

std::vector<vision::SlowPart> slow_from(const JsonPlace& meta) {
  std::vector<vision::SlowPart> slow;
  for (const JsonPlace& part : meta.items("slow_errors"))
    slow.push_back({part.text("from"), part.at("sd_px").number(), part.at("time_s").number()});
  return slow;
}

vision::Audit audit_from(const JsonPlace& json) {
  vision::Audit audit;
  audit.halves_x = number_at(json, "halves_x");
  audit.halves_y = number_at(json, "halves_y");
  audit.high_frequency = number_at(json, "high_frequency");
  audit.frames = json.whole("frames", 0);
  audit.white_factor = json.number("white_factor", 1);
  audit.slow_sd = json.number("slow_sd_px", 0);
  audit.slow_time = json.number("slow_time_s", 0);
  return audit;
}

Track track_from(const JsonPlace& meta) {
  Track track;
  static const Json nothing = Json::object();
  const auto section = [&](const char* key) {
    const auto found = meta.find(key);
    return found ? *found : JsonPlace{nothing, key};
  };
  if (const auto scale = meta.find("scale")) {
    track.mm_per_px = scale->number("mm_per_px", 0);
    track.mm_per_px_sd = scale->number("mm_per_px_sd", 0);
    track.scale_source = scale->text("source");
  }
  track.xi_axis_rad = section("configuration").number("xi_axis_rad", 0);
  const JsonPlace recording = section("recording"), time_base = section("time_base");
  track.exposure_s = number_at(recording, "exposure_s");
  track.frame_rate_hz = number_at(time_base, "rate_hz");
  track.recorded_at = recording.text("trigger_time");
  if (recording.text("format") == "cine") {
    const auto first = number_at(recording, "first_image");
    if (first && track.frame_rate_hz) track.trigger_time_s = -*first / *track.frame_rate_hz;
  }
  const JsonPlace summary = section("summary");
  track.gate_clipped_share = summary.number("gate_clipped_share", 0);
  track.disc_radius_common_sd_px = summary.number("disc_radius_common_sd_px", 0);
  if (const auto disc = summary.find("disc_px")) track.disc_radius_px = disc->at(2).number();
  track.slow = slow_from(meta);
  track.audit = audit_from(section("audit"));
  if (const auto coding = meta.find("coding")) {
    track.coding.emplace().coder = coding->text("coder");
    track.coding->mark_play = coding->number("mark_play_px", 0);
  }
  track.lost_counted = summary.whole("lost_counted", 0);
  track.accepted = summary.boolean("gate_passed", true);
  track.rests_for_ever = summary.boolean("rests_for_ever", false);
  track.platform_from_texture = meta.text("platform_seen_by") == "texture";
  track.time_base = time_base.text("source");
  track.missing = time_base.whole("missing", 0);
  track.width_px = recording.integer("width", 0);
  track.height_px = recording.integer("height", 0);
  track.in_camera_frame = meta.text("frame_of_reference") == "camera";
  track.imported = section("imported").text("reading");
  track.sd_from_scatter = summary.boolean("sd_from_scatter", false);
  track.table.noise_dof = summary.number("sd_dof", 0);
  track.warnings = summary.texts("warnings");
  for (const JsonPlace& input : meta.items("inputs"))
    track.recorded_in.push_back({input.at("path").text(), input.text("xxh3_128"), input.text("hashed")});
  for (const JsonPlace& stage : meta.items("plan"))
    track.plan.push_back({stage.at("stage").text(), stage.at("on").boolean(), stage.text("reason"),
                          number_at(stage, "error_bound_px")});
  return track;
}

}  // namespace

Track with_rows(Track track, const TrackRows& rows, const std::filesystem::path& path) {
  track.table.platform_frame = rows.has_marker || (!track.imported.empty() && !track.in_camera_frame);
  track.table.exposure = track.exposure_s.value_or(0);
  track.table.radius = track.disc_radius_px * track.mm_per_px.value_or(0) * 1e-3;
  track.table.round = track.disc_radius_px > 0;
  for (const vision::SlowPart& part : track.slow)
    if (track.mm_per_px && part.sd > 0 && part.time > 0)
      track.table.slow.push_back({part.sd * *track.mm_per_px * 1e-3, part.time});
  track.lamp.exposure = track.exposure_s;
  track.lamp.clipped = track.gate_clipped_share > kClippedShare;
  track.frames = rows.rows.size();
  const FitTable fit_table(rows, track, path);
  for (const TrackRow& row : rows.rows) {
    if (row.status == vision::TrackStatus::lost) ++track.lost;
    if (row.status == vision::TrackStatus::edge) ++track.edge;
    if (row.status == vision::TrackStatus::repeat) ++track.repeats;
    track.x_px.push_back(row.x_px);
    track.y_px.push_back(row.y_px);
    track.x_mm.push_back(row.x_mm);
    track.y_mm.push_back(row.y_mm);
    track.sigma_px.push_back(row.sigma_x_px);
    track.ncc.push_back(row.ncc);
    track.time_s.push_back(row.time_s);
    if (rows.has_rotation) {
      track.theta_rad.push_back(row.theta_rad);
      track.sigma_theta_rad.push_back(row.sigma_theta_rad);
    }
    if (!std::isnan(row.gate)) {
      track.lamp.time.push_back(row.time_s);
      track.lamp.level.push_back(row.gate);
    }
    if (row.status != vision::TrackStatus::ok) continue;
    if (!std::isnan(row.x_mm)) fit_table.add(row, track.table);
    if (rows.has_marker && std::isnan(row.marker_x_px) && std::isnan(row.marker_x_mm)) ++track.without_mark;
  }
  return track;
}

Track track_described_by(const Json& meta, const std::filesystem::path& path) {
  const bool of_another_command =
      meta.is_object() && meta.contains("command") && meta.at("command") != "track";
  if (!meta.is_object() || meta.empty() || of_another_command)
    throw InvalidInput(
        "{}: is not the meta file of a track; track the recording again, or put back the file that "
        "`tribotrack track` wrote",
        path.string());
  require_known_schema(meta, path);
  try {
    return track_from({meta, ""});
  } catch (const WrongContent& error) {
    throw InvalidInput(
        "{}: is not the meta file of a track ({}); track the recording again, or delete this file",
        path.string(), error.what());
  }
}

Track track_of_text(const std::filesystem::path& path, std::string text, const std::optional<Json>& meta) {
  const std::filesystem::path meta_path = path.string() + ".meta.json";
  Track track;
  if (meta) track = track_described_by(*meta, meta_path);
  const TrackRows rows = read_track_rows(path, std::move(text));
  if (rows.has_marker && !rows.has_planes && !track.mm_per_px)
    throw InvalidInput(
        "{}: without it the marker's columns of {} have no scale; put it back beside the table, or make both "
        "again with `tribotrack track`",
        meta_path.string(), path.string());
  return with_rows(std::move(track), rows, path);
}

Track read_track_file(const std::filesystem::path& path) {
  if (std::filesystem::is_directory(path))
    throw InvalidInput("{}: is a folder; name a track, such as {}", path.string(),
                       (path / "NAME.csv").string());
  if (!std::filesystem::is_regular_file(path))
    throw InvalidInput("{}: there is no such track; make one with `tribotrack track`", path.string());
  std::string text = read_text(path);
  if (text.find('\0') != std::string::npos)
    throw InvalidInput(
        "{}: is no table but a binary file; if it is a recording, `tribotrack track` makes a track of it",
        path.string());
  const std::filesystem::path meta_path = path.string() + ".meta.json";
  std::optional<Json> meta;
  if (std::filesystem::exists(meta_path)) meta = read_json(meta_path);
  Input input = hashed_input(path, text);
  Track track = track_of_text(path, std::move(text), meta);
  track.inputs = {std::move(input)};
  return track;
}

}  // namespace tribotrack::apps
