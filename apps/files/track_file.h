// The track table on disk: T.csv and what its meta file adds.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "apps/files/meta_file.h"
#include "fit/gate_timing.h"
#include "fit/track_table.h"
#include "vision/millimetres.h"
#include "vision/track.h"

namespace tribotrack::apps {

/// The CSV of a track, columns as the interface promises. Without a scale the millimetre columns stay empty.
/// Where the marker's plane has another scale than the part's top, or a lens is corrected, four columns more:
/// rho_xy_mm,marker_x_mm,marker_y_mm,marker_sigma_mm.
std::string track_csv(const vision::Track& track, const std::optional<vision::PlaneGeometry>& geometry,
                      double xi_axis_rad);

/// A track read back.
struct TrackFile {
  fit::TrackTable table;  ///< rows with status ok, SI
  std::size_t frames = 0, lost = 0, edge = 0;
  /// For pictures of the path: one per row, NaN where the part was not measured.
  std::vector<double> x_px, y_px, x_mm, y_mm, sigma_px;
  bool has_marker_columns = false;
  bool platform_from_texture = false;  ///< the marker's columns follow a patch of the platform's own texture
  std::optional<double> mm_per_px;     ///< from the meta file; without it the marker's motion stays unknown
  std::optional<double> mm_per_px_sd;
  fit::LampRecord lamp;  ///< the gate's lamp in every frame that shows it; empty where none was named
  Json meta;             ///< null where there is none
};

/// The trigger in the recording's time, s: a recording that numbers its images from the trigger says it by
/// the number of its first. nullopt where the format has no such numbers.
std::optional<double> trigger_time_of(const TrackFile& track);

/// Throws InvalidInput naming the file and the column or line that is wrong.
TrackFile read_track_file(const std::filesystem::path& path);

}  // namespace tribotrack::apps
