// From one recording to its track table: what `track` does once and `run` for every video.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "apps/files/meta_file.h"
#include "vision/frame_source.h"
#include "vision/millimetres.h"
#include "vision/track.h"
#include "vision/tracker.h"

namespace tribotrack::apps {

struct RecordingJob {
  std::filesystem::path video;
  std::optional<double> frame_rate_hz;
  std::optional<double> mm_per_px;  ///< of the platform's plane; beats diameter_mm
  double mm_per_px_sd = 0;
  std::optional<std::filesystem::path> calibration;  ///< of the camera; beats diameter_mm
  std::optional<double> diameter_mm;                 ///< of the part's top
  double diameter_sd_mm = 0;
  std::optional<double> height_mm;  ///< of the part's top above the platform
  std::optional<double>
      working_distance_mm;  ///< from the lens to the platform; a calibration knows it itself
  double xi_axis_rad = 0;
  vision::TrackOptions track;
  Json configuration() const;  ///< effective, for the meta file
  /// What the result depends on: program version, configuration and the video's bytes.
  std::string key() const;
};

struct TrackedRecording {
  vision::SourceInfo info;
  vision::TrackResult result;
  std::optional<vision::PlaneGeometry> geometry;  ///< nothing where neither scale nor diameter was given
  std::optional<vision::Scale> scale;             ///< of the part's top, where there is a geometry
};

/// Throws vision::InputError where the recording cannot be tracked, with the flag to give where its frame
/// rate is unknown.
TrackedRecording track_recording(const RecordingJob& job);

/// Writes T.csv and T.csv.meta.json.
void write_track(const std::filesystem::path& csv, const RecordingJob& job,
                 const TrackedRecording& recording);

/// Summary of the track as JSON (`track --json`, meta file).
Json summary_json(const TrackedRecording& recording);

/// Is csv there with a meta file of this key?
bool is_current(const std::filesystem::path& csv, const std::string& key);

}  // namespace tribotrack::apps
