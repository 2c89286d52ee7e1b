#include "apps/files/track_file.h"

#include <fmt/format.h>
// The library cuts long file names on purpose; the compiler warns where it inlines that.
#pragma GCC diagnostic ignored "-Wstringop-truncation"
#include <libfccp/csv.h>

#include <Eigen/Geometry>
#include <cmath>

#include "apps/program/errors.h"
#include "apps/text/angle.h"
#include "apps/text/number_text.h"

namespace tribotrack::apps {

namespace {

constexpr const char* kColumns =
    "frame,time_s,x_px,y_px,sigma_x_px,sigma_y_px,rho_xy,ncc,status,x_mm,y_mm,sigma_x_mm,sigma_y_mm";
constexpr const char* kMarkerColumns = ",marker_x_px,marker_y_px,marker_sigma_px,marker_ncc";
constexpr const char* kGateColumn = ",gate";
constexpr double kClippedShare = 0.02;  ///< of the lamp's pixels: above it its brightness is not linear

constexpr const char* kPlacedColumns = ",rho_xy_mm,marker_x_mm,marker_y_mm,marker_sigma_mm";

std::string placed_cells(const std::optional<vision::PlacedPoint>& point) {
  if (!point) return ",,,,";
  const Eigen::Matrix2d& c = point->covariance;
  const double rho = c(0, 1) / std::sqrt(c(0, 0) * c(1, 1));
  if (!point->marker_mm) return fmt::format(",{},,,", compact(rho));
  return fmt::format(",{},{},{},{}", compact(rho), compact(point->marker_mm->x()),
                     compact(point->marker_mm->y()), compact(point->marker_sigma_mm));
}

/// Takes camera pixels (y down) to metres in campaign axes (y up, turned by -xi_axis).
Eigen::Matrix2d to_campaign_axes(double mm_per_px, double xi_axis_rad) {
  const Eigen::Matrix2d up = Eigen::Vector2d(1, -1).asDiagonal();
  return mm_per_px * 1e-3 * Eigen::Rotation2Dd(-xi_axis_rad).toRotationMatrix() * up;
}

Eigen::Matrix2d covariance_of(double sd_x, double sd_y, double correlation) {
  const double off = correlation * sd_x * sd_y;
  return (Eigen::Matrix2d() << sd_x * sd_x, off, off, sd_y * sd_y).finished();
}

}  // namespace

std::string track_csv(const vision::Track& track, const std::optional<vision::PlaneGeometry>& geometry,
                      double xi_axis_rad) {
  std::vector<std::optional<vision::PlacedPoint>> millimetres(track.points.size());
  if (geometry) millimetres = vision::place_track(track, *geometry, xi_axis_rad);
  const bool placed_columns = geometry && !geometry->plain();
  std::string csv = kColumns;
  if (track.has_marker) csv += kMarkerColumns;
  if (track.has_gate) csv += kGateColumn;
  if (placed_columns) csv += kPlacedColumns;
  csv += '\n';
  for (std::size_t k = 0; k < track.points.size(); ++k) {
    const vision::TrackPoint& p = track.points[k];
    const auto& mm = millimetres[k];
    csv += fmt::format("{},{},", p.frame, exact(p.time_s));
    if (p.status == vision::TrackStatus::ok)
      csv += fmt::format("{},{},{},{},{},{},", compact(p.x), compact(p.y), compact(p.sigma_x),
                         compact(p.sigma_y), compact(p.rho_xy), compact(p.ncc));
    else
      csv += ",,,,,,";
    csv += vision::to_string(p.status);
    if (mm)
      csv += fmt::format(",{},{},{},{}", compact(mm->mm.x()), compact(mm->mm.y()),
                         compact(std::sqrt(mm->covariance(0, 0))), compact(std::sqrt(mm->covariance(1, 1))));
    else
      csv += ",,,,";
    if (track.has_marker)
      csv += p.marker ? fmt::format(",{},{},{},{}", compact(p.marker->x), compact(p.marker->y),
                                    compact(p.marker->sigma), compact(p.marker->ncc))
                      : std::string(",,,,");
    if (track.has_gate) csv += p.gate ? "," + compact(*p.gate) : std::string(",");
    if (placed_columns) csv += placed_cells(mm);
    csv += '\n';
  }
  return csv;
}

TrackFile read_track_file(const std::filesystem::path& path) {
  if (!std::filesystem::is_regular_file(path))
    throw InvalidInput(
        fmt::format("{}: there is no such track; make one with `tribotrack track`", path.string()));
  TrackFile file;
  const std::filesystem::path meta = path.string() + ".meta.json";
  double xi_axis_rad = 0;
  if (std::filesystem::exists(meta)) {
    file.meta = read_json(meta);
    if (const auto scale = file.meta.find("scale"); scale != file.meta.end() && scale->is_object()) {
      file.mm_per_px = scale->value("mm_per_px", 0.0);
      file.mm_per_px_sd = scale->value("mm_per_px_sd", 0.0);
    }
    if (const auto configuration = file.meta.find("configuration"); configuration != file.meta.end())
      xi_axis_rad = configuration->value("xi_axis_rad", 0.0);
  }
  try {
    io::CSVReader<20, io::trim_chars<' ', '\t', '\r'>, io::no_quote_escape<','>> csv(path.string());
    csv.read_header(io::ignore_extra_column | io::ignore_missing_column, "frame", "time_s", "status", "x_mm",
                    "y_mm", "sigma_x_mm", "sigma_y_mm", "rho_xy", "marker_x_px", "marker_y_px",
                    "marker_sigma_px", "x_px", "y_px", "sigma_x_px", "sigma_y_px", "gate", "rho_xy_mm",
                    "marker_x_mm", "marker_y_mm", "marker_sigma_mm");
    for (const char* needed : {"frame", "time_s", "status", "x_mm", "y_mm", "sigma_x_mm", "sigma_y_mm"})
      if (!csv.has_column(needed))
        throw InvalidInput(
            fmt::format("{}: has no column `{}`; a track has {}", path.string(), needed, kColumns));
    file.has_marker_columns = csv.has_column("marker_x_px");
    const bool placed = csv.has_column("rho_xy_mm");
    const char *frame = "", *time = "", *status = "", *x = "", *y = "", *sx = "", *sy = "", *rho = "0",
               *mx = "", *my = "", *ms = "", *xp = "", *yp = "", *sxp = "", *syp = "", *gate = "",
               *rho_mm = "", *mx_mm = "", *my_mm = "", *ms_mm = "";
    while (csv.read_row(frame, time, status, x, y, sx, sy, rho, mx, my, ms, xp, yp, sxp, syp, gate, rho_mm,
                        mx_mm, my_mm, ms_mm)) {
      ++file.frames;
      const std::string_view state = status;
      if (state == "lost") ++file.lost;
      if (state == "edge") ++file.edge;
      const auto or_nan = [](const char* text) { return parse_number(text).value_or(std::nan("")); };
      file.x_px.push_back(or_nan(xp));
      file.y_px.push_back(or_nan(yp));
      file.x_mm.push_back(or_nan(x));
      file.y_mm.push_back(or_nan(y));
      file.sigma_px.push_back(or_nan(sxp));
      if (const auto level = parse_number(gate)) {
        file.lamp.time.push_back(or_nan(time));
        file.lamp.level.push_back(*level);
      }
      if (state != "ok" || *x == '\0') continue;  // an ok disc without its marker has no platform position
      const auto number = [&](const char* text, const char* column) {
        const auto value = parse_number(text);
        if (!value)
          throw InvalidInput(fmt::format("{}:{}: `{}` is not a number in column {}", path.string(),
                                         csv.get_file_line(), text, column));
        return *value;
      };
      // The covariance in pixels carries the correlation; the table's mm columns only the two standard
      // deviations.
      Eigen::Matrix2d covariance;
      const double rho_px = *rho == '\0' ? 0 : number(rho, "rho_xy");
      if (placed) {
        covariance = covariance_of(number(sx, "sigma_x_mm") * 1e-3, number(sy, "sigma_y_mm") * 1e-3,
                                   number(rho_mm, "rho_xy_mm"));
      } else if (file.mm_per_px && *sxp != '\0' && *syp != '\0') {
        const Eigen::Matrix2d turn = to_campaign_axes(*file.mm_per_px, xi_axis_rad);
        const double marker_px = *ms == '\0' ? 0 : number(ms, "marker_sigma_px");
        covariance = turn * covariance_of(number(sxp, "sigma_x_px"), number(syp, "sigma_y_px"), rho_px) *
                         turn.transpose() +
                     std::pow(marker_px * *file.mm_per_px * 1e-3, 2) * Eigen::Matrix2d::Identity();
      } else {
        covariance = covariance_of(number(sx, "sigma_x_mm") * 1e-3, number(sy, "sigma_y_mm") * 1e-3, -rho_px);
      }
      file.table.frame.push_back(static_cast<std::int64_t>(number(frame, "frame")));
      file.table.time.push_back(number(time, "time_s"));
      file.table.position.emplace_back(number(x, "x_mm") * 1e-3, number(y, "y_mm") * 1e-3);
      file.table.covariance.push_back(covariance);
      if (file.has_marker_columns && placed) {
        file.table.marker.push_back(
            1e-3 * Eigen::Vector2d(number(mx_mm, "marker_x_mm"), number(my_mm, "marker_y_mm")));
        file.table.marker_sigma.push_back(number(ms_mm, "marker_sigma_mm") * 1e-3);
      } else if (file.has_marker_columns && file.mm_per_px) {
        file.table.marker.push_back(to_campaign_axes(*file.mm_per_px, xi_axis_rad) *
                                    Eigen::Vector2d(number(mx, "marker_x_px"), number(my, "marker_y_px")));
        file.table.marker_sigma.push_back(number(ms, "marker_sigma_px") * *file.mm_per_px * 1e-3);
      }
    }
  } catch (const io::error::base& error) {
    throw InvalidInput(fmt::format("{}: is not a track: {}", path.string(), error.what()));
  }
  if (const auto recording = file.meta.find("recording"); recording != file.meta.end())
    if (const Json exposure = recording->value("exposure_s", Json()); exposure.is_number()) {
      file.table.exposure = exposure.get<double>();
      file.lamp.exposure = exposure.get<double>();
    }
  if (const auto summary = file.meta.find("summary"); summary != file.meta.end())
    file.lamp.clipped = summary->value("gate_clipped_share", 0.0) > kClippedShare;
  file.platform_from_texture = file.meta.is_object() && file.meta.value("platform_seen_by", "") == "texture";
  file.table.platform_frame = file.has_marker_columns;
  return file;
}

std::optional<double> trigger_time_of(const TrackFile& track) {
  if (!track.meta.is_object()) return std::nullopt;
  try {
    const Json& recording = track.meta.at("recording");
    if (recording.at("format") != "cine") return std::nullopt;
    return -recording.at("first_image").get<double>() /
           track.meta.at("time_base").at("rate_hz").get<double>();
  } catch (const Json::exception&) {
    return std::nullopt;
  }
}

}  // namespace tribotrack::apps
