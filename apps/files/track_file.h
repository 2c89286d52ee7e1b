// A track as measuring and fitting take it: its table, T.csv, and what its meta file adds.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "apps/files/track_rows.h"
#include "apps/text/input_file.h"
#include "apps/text/json.h"
#include "fit/gate_timing.h"
#include "fit/track_table.h"
#include "vision/track.h"

namespace tribotrack::apps {

/// What its meta file says, and its rows as measuring and drawing take them.
struct Track {
  std::optional<double> mm_per_px, mm_per_px_sd;  ///< of the part's top; without: the marker's motion unknown
  std::string scale_source;                       ///< "given", "part's diameter", ...
  double xi_axis_rad = 0;
  std::optional<double> exposure_s;
  double gate_clipped_share = 0;       ///< of the lamp's pixels
  bool platform_from_texture = false;  ///< the marker's columns follow a patch of the platform's own texture
  double disc_radius_px = 0, disc_radius_common_sd_px = 0;
  std::int64_t lost_counted = 0;
  bool accepted = true;         ///< the part was lost in no more frames than allowed, and is no mark at rest
  bool rests_for_ever = false;  ///< the disc was found by itself and never moves
  std::optional<double> trigger_time_s;  ///< of a recording that numbers its images from the trigger
  std::string recorded_at;               ///< ISO 8601 UTC, empty where the recording does not say
  std::vector<Input> recorded_in;        ///< the recording and, where there is one, the calibration
  std::optional<double> frame_rate_hz;
  std::string time_base;  ///< where the frame rate comes from
  int width_px = 0, height_px = 0;
  bool in_camera_frame = false;  ///< no marker: positions hold the platform's motion
  std::string imported;          ///< how another program's track was read, one sentence; empty: it is ours
  bool sd_from_scatter = false;  ///< it had no sds: slow errors are not in them
  std::vector<std::string> warnings;
  /// Errors that neighbouring frames share, in the rows' standard deviations.
  std::vector<vision::SlowPart> slow;
  vision::Audit audit;
  std::optional<vision::CodedErrors> coding;  ///< of a lossy recording: coder and mark_play alone
  std::vector<vision::PlanStage> plan;

  fit::TrackTable table;  ///< rows with status ok, SI
  std::size_t frames = 0, lost = 0, edge = 0, repeats = 0;
  /// Frames that show the part, but not the platform's mark: they have no place on it.
  std::size_t without_mark = 0;
  std::int64_t missing = 0;  ///< frames that should stand between the recording's, by its timestamps
  /// For pictures of the path: one per row, NaN where the part was not measured.
  std::vector<double> time_s, x_px, y_px, x_mm, y_mm, sigma_px, ncc;
  /// The part's rotation, one per row, NaN where it is not seen; empty where it is nowhere.
  std::vector<double> theta_rad, sigma_theta_rad;
  fit::LampRecord lamp;  ///< the gate's lamp in every frame that shows it; empty where none was named

  std::vector<Input> inputs;  ///< what it was read from: T.csv, or the recording just tracked
};

/// What a meta file says of its track; keys that are not there keep their defaults. Throws InvalidInput
/// naming `path` where one is not of its type.
Track track_described_by(const Json& meta, const std::filesystem::path& path);

/// The same with its rows. Throws InvalidInput naming `path` and the frame and column that is missing.
Track with_rows(Track track, const TrackRows& rows, const std::filesystem::path& path);

/// Of the texts of T.csv and its meta file, `path` standing in messages. `inputs` stay empty.
Track track_of_text(const std::filesystem::path& path, std::string text, const std::optional<Json>& meta);

/// Reads T.csv and, where there is one, T.csv.meta.json. Throws InvalidInput naming file, line and column.
Track read_track_file(const std::filesystem::path& path);

}  // namespace tribotrack::apps
