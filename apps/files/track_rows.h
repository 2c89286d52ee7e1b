// The table of a track, T.csv: one row a frame, numbers as they stand in the file.
#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "apps/text/csv_table.h"
#include "vision/millimetres.h"
#include "vision/track.h"

namespace tribotrack::apps {

/// One frame. NaN is an empty cell.
struct TrackRow {
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  std::int64_t frame = 0;
  double time_s = 0;
  double x_px = kNone, y_px = kNone, sigma_x_px = kNone, sigma_y_px = kNone, rho_xy = kNone, ncc = kNone;
  vision::TrackStatus status = vision::TrackStatus::lost;
  double x_mm = kNone, y_mm = kNone, sigma_x_mm = kNone, sigma_y_mm = kNone;
  double theta_rad = kNone, sigma_theta_rad = kNone;
  double marker_x_px = kNone, marker_y_px = kNone, marker_sigma_px = kNone, marker_ncc = kNone;
  double gate = kNone;
  double rho_xy_mm = kNone, marker_x_mm = kNone, marker_y_mm = kNone, marker_sigma_mm = kNone;
};

struct TrackRows {
  bool has_rotation = false;  ///< theta_rad, sigma_theta_rad
  bool has_marker = false;    ///< marker_x_px .. marker_ncc
  bool has_gate = false;      ///< gate
  bool has_planes = false;    ///< rho_xy_mm .. marker_sigma_mm
  std::vector<TrackRow> rows;
};

/// The rows of a track, every number rounded as the file holds it, so that a track just made and one read
/// back are the same. Without a geometry the millimetre columns stay empty; where the marker's plane has
/// another scale than the part's top, or a lens is corrected, there are four more columns. Without `pixels`
/// the track is in lengths: these columns there are, and the pixels' are empty.
TrackRows track_rows(const vision::Track& track, const std::optional<vision::PlaneGeometry>& geometry,
                     double xi_axis_rad, bool pixels = true);

/// The columns that a table has, in the order and under the names that the interface promises, and its CSV.
Columns columns_of(const TrackRows& rows);
std::string track_csv(const TrackRows& rows);

/// Reads a CSV's text; `path` stands in messages. Columns may be in any order, others are ignored. Throws
/// InvalidInput naming file, line and column of what is wrong.
TrackRows read_track_rows(const std::filesystem::path& path, std::string text);

}  // namespace tribotrack::apps
