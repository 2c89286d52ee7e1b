#include "apps/files/track_file.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>

#include "apps/files/meta_file.h"
#include "apps/program/errors.h"
#include "apps/text/strict_toml.h"

namespace tribotrack::apps {

namespace {

constexpr double kClippedShare = 0.02;  ///< of the lamp's pixels: above it its brightness is not linear

/// Takes camera pixels (y down) to metres in campaign axes (y up, turned by -xi_axis).
Eigen::Matrix2d to_campaign_axes(double mm_per_px, double xi_axis_rad) {
  const Eigen::Matrix2d up = Eigen::Vector2d(1, -1).asDiagonal();
  return mm_per_px * 1e-3 * Eigen::Rotation2Dd(-xi_axis_rad).toRotationMatrix() * up;
}

Eigen::Matrix2d covariance_of(double sd_x, double sd_y, double correlation) {
  const double off = correlation * sd_x * sd_y;
  return (Eigen::Matrix2d() << sd_x * sd_x, off, off, sd_y * sd_y).finished();
}

/// The measured rows of a track as the fit's table.
class FitTable {
 public:
  FitTable(const TrackRows& rows, const TrackFacts& facts, const std::filesystem::path& path)
      : rows_(rows), facts_(facts), path_(path) {
    if (facts.mm_per_px) axes_ = to_campaign_axes(*facts.mm_per_px, facts.xi_axis_rad);
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
    } else if (rows_.has_marker && facts_.mm_per_px) {
      table.marker.push_back(axes_ * Eigen::Vector2d(present(row, row.marker_x_px, "marker_x_px"),
                                                     present(row, row.marker_y_px, "marker_y_px")));
      table.marker_sigma.push_back(present(row, row.marker_sigma_px, "marker_sigma_px") * *facts_.mm_per_px *
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
    if (facts_.mm_per_px && !std::isnan(row.sigma_x_px) && !std::isnan(row.sigma_y_px)) {
      const double marker_px = std::isnan(row.marker_sigma_px) ? 0 : row.marker_sigma_px;
      return axes_ * covariance_of(row.sigma_x_px, row.sigma_y_px, rho_px) * axes_.transpose() +
             std::pow(marker_px * *facts_.mm_per_px * 1e-3, 2) * Eigen::Matrix2d::Identity();
    }
    return covariance_of(present(row, row.sigma_x_mm, "sigma_x_mm") * 1e-3,
                         present(row, row.sigma_y_mm, "sigma_y_mm") * 1e-3, -rho_px);
  }
  double present(const TrackRow& row, double value, const char* column) const {
    if (std::isnan(value))
      throw InvalidInput(fmt::format("{}: frame {} is ok and has x_mm, but no number in column {}",
                                     path_.string(), row.frame, column));
    return value;
  }

  double positive(const TrackRow& row, double value, const char* column) const {
    if (value > 0) return value;
    throw InvalidInput(fmt::format("{}: frame {} has theta_rad, but no positive number in column {}",
                                   path_.string(), row.frame, column));
  }

  const TrackRows& rows_;
  const TrackFacts& facts_;
  const std::filesystem::path& path_;
  Eigen::Matrix2d axes_ = Eigen::Matrix2d::Identity();
};

std::optional<double> number_at(const Json& object, const char* key) {
  const auto found = object.find(key);
  if (found == object.end() || found->is_null()) return std::nullopt;
  return found->get<double>();
}

/// A track of an older version has their sum alone.
std::vector<vision::SlowPart> slow_from(const Json& meta, const Json& summary) {
  std::vector<vision::SlowPart> slow;
  if (const auto parts = meta.find("slow_errors"); parts != meta.end()) {
    for (const Json& part : *parts)
      slow.push_back(
          {part.value("from", ""), part.at("sd_px").get<double>(), part.at("time_s").get<double>()});
    return slow;
  }
  if (const double sd = number_at(summary, "slow_sd_px").value_or(0); sd > 0)
    slow.push_back({"all", sd, number_at(summary, "slow_time_s").value_or(0)});
  return slow;
}

vision::Audit audit_from(const Json& json) {
  vision::Audit audit;
  audit.halves_x = number_at(json, "halves_x");
  audit.halves_y = number_at(json, "halves_y");
  audit.checkerboard = number_at(json, "checkerboard");
  audit.high_frequency = number_at(json, "high_frequency");
  audit.pixel_phase = number_at(json, "pixel_phase");
  audit.lag1 = number_at(json, "lag1");
  audit.frames = json.value("frames", std::int64_t{0});
  audit.white_factor = json.value("white_factor", 1.0);
  audit.slow_sd = json.value("slow_sd_px", 0.0);
  audit.slow_time = json.value("slow_time_s", 0.0);
  if (const auto types = json.find("by_frame_type"); types != json.end() && types->is_object())
    for (const auto& [type, ratio] : types->items())
      audit.by_frame_type.emplace_back(type.empty() ? '?' : type.front(), ratio.get<double>());
  return audit;
}

std::optional<vision::CodedResponse> response_from(const Json& json, const char* key) {
  const auto found = json.find(key);
  if (found == json.end() || !found->is_object()) return std::nullopt;
  return vision::CodedResponse{found->at("attenuation").get<double>(),
                               found->at("attenuation_sd").get<double>(), found->at("delay_s").get<double>(),
                               found->at("delay_s_sd").get<double>()};
}

std::optional<CodingFacts> coding_from(const Json& json) {
  if (json.empty()) return std::nullopt;
  CodingFacts facts;
  facts.coder = json.value("coder", "");
  facts.rehearsed = json.value("rehearsed", false);
  facts.part_play_px = json.value("part_play_px", 0.0);
  facts.mark_play_px = json.value("mark_play_px", 0.0);
  facts.part = response_from(json, "part_response");
  facts.mark = response_from(json, "mark_response");
  return facts;
}

}  // namespace

TrackFile track_file_of(const TrackRows& rows, const TrackFacts& facts, const std::filesystem::path& path) {
  TrackFile file;
  file.facts = facts;
  file.mm_per_px = facts.mm_per_px;
  file.mm_per_px_sd = facts.mm_per_px_sd;
  file.platform_from_texture = facts.platform_from_texture;
  file.has_marker_columns = rows.has_marker;
  file.table.platform_frame = rows.has_marker;
  file.table.exposure = facts.exposure_s.value_or(0);
  file.table.radius = facts.disc_radius_px * facts.mm_per_px.value_or(0) * 1e-3;
  for (const vision::SlowPart& part : facts.slow)
    if (facts.mm_per_px && part.sd > 0 && part.time > 0)
      file.table.slow.push_back({part.sd * *facts.mm_per_px * 1e-3, part.time});
  file.lamp.exposure = facts.exposure_s;
  file.lamp.clipped = facts.gate_clipped_share > kClippedShare;
  file.frames = rows.rows.size();
  const FitTable fit_table(rows, facts, path);
  for (const TrackRow& row : rows.rows) {
    if (row.status == vision::TrackStatus::lost) ++file.lost;
    if (row.status == vision::TrackStatus::edge) ++file.edge;
    file.x_px.push_back(row.x_px);
    file.y_px.push_back(row.y_px);
    file.x_mm.push_back(row.x_mm);
    file.y_mm.push_back(row.y_mm);
    file.sigma_px.push_back(row.sigma_x_px);
    if (rows.has_rotation) {
      file.time_s.push_back(row.time_s);
      file.theta_rad.push_back(row.theta_rad);
      file.sigma_theta_rad.push_back(row.sigma_theta_rad);
    }
    if (!std::isnan(row.gate)) {
      file.lamp.time.push_back(row.time_s);
      file.lamp.level.push_back(row.gate);
    }
    // An ok disc without its marker has no platform position.
    if (row.status == vision::TrackStatus::ok && !std::isnan(row.x_mm)) fit_table.add(row, file.table);
  }
  return file;
}

TrackFacts track_facts_from(const Json& meta, const std::filesystem::path& path) {
  require_known_schema(meta, path);
  TrackFacts facts;
  const auto object_at = [&](const char* key) {
    const auto found = meta.find(key);
    return found != meta.end() && found->is_object() ? *found : Json::object();
  };
  try {
    if (const Json scale = object_at("scale"); !scale.empty()) {
      facts.mm_per_px = number_at(scale, "mm_per_px").value_or(0);
      facts.mm_per_px_sd = number_at(scale, "mm_per_px_sd").value_or(0);
      facts.scale_source = scale.value("source", "");
    }
    facts.xi_axis_rad = number_at(object_at("configuration"), "xi_axis_rad").value_or(0);
    const Json recording = object_at("recording");
    facts.exposure_s = number_at(recording, "exposure_s");
    if (recording.value("format", "") == "cine") {
      const auto first = number_at(recording, "first_image");
      const auto rate = number_at(object_at("time_base"), "rate_hz");
      if (first && rate) facts.trigger_time_s = -*first / *rate;
    }
    const Json summary = object_at("summary");
    facts.gate_clipped_share = number_at(summary, "gate_clipped_share").value_or(0);
    facts.disc_radius_common_sd_px = number_at(summary, "disc_radius_common_sd_px").value_or(0);
    if (const auto disc = summary.find("disc_px"); disc != summary.end() && disc->size() == 3)
      facts.disc_radius_px = disc->at(2).get<double>();
    facts.slow = slow_from(meta, summary);
    facts.audit = audit_from(object_at("audit"));
    facts.coding = coding_from(object_at("coding"));
    facts.frames = summary.value("frames", std::int64_t{0});
    facts.lost_counted = summary.value("lost_counted", std::int64_t{0});
    facts.accepted = summary.value("gate_passed", true);
    facts.rests_for_ever = summary.value("rests_for_ever", false);
    facts.platform_from_texture = meta.value("platform_seen_by", "") == "texture";
    facts.frame_rate_hz = number_at(object_at("time_base"), "rate_hz");
    facts.time_base = object_at("time_base").value("source", "");
    facts.width_px = recording.value("width", 0);
    facts.height_px = recording.value("height", 0);
    facts.in_camera_frame = meta.value("frame_of_reference", "") == "camera";
    facts.warnings = summary.value("warnings", std::vector<std::string>());
    for (const Json& input : meta.value("inputs", Json::array()))
      facts.recorded_in.push_back(
          {input.at("path").get<std::string>(), input.value("xxh3_128", ""), input.value("hashed", "")});
    for (const Json& stage : meta.value("plan", Json::array()))
      facts.plan.push_back({stage.at("stage").get<std::string>(), stage.at("on").get<bool>(),
                            stage.value("reason", ""), number_at(stage, "error_bound_px")});
  } catch (const Json::exception& error) {
    throw InvalidInput(fmt::format(
        "{}: is not the meta file of a track ({}); track the recording again, or delete this file",
        path.string(), error.what()));
  }
  return facts;
}

TrackFile read_track_file(const std::filesystem::path& path) {
  if (!std::filesystem::is_regular_file(path))
    throw InvalidInput(
        fmt::format("{}: there is no such track; make one with `tribotrack track`", path.string()));
  const std::filesystem::path meta_path = path.string() + ".meta.json";
  TrackFacts facts;
  if (std::filesystem::exists(meta_path)) facts = track_facts_from(read_json(meta_path), meta_path);
  std::string text = read_text(path);
  Input input = hashed_input(path, text);
  TrackFile file = track_file_of(read_track_rows(path, std::move(text)), facts, path);
  file.inputs = {std::move(input)};
  return file;
}

}  // namespace tribotrack::apps
