// What `track` can be told: each a flag of the command line, and a keyword in Python.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "apps/recording/track_recording.h"
#include "vision/tracker.h"

namespace tribotrack::apps {

/// Empty: not given. Units as in the flags' names.
struct TrackChoices {
  std::optional<double> fps, mm_per_px, disc_diameter_mm, height_mm, working_distance_mm, xi_axis_rad, tag_mm;
  std::string fps_reason;
  std::string calibration, config;  ///< files
  std::optional<vision::Circle> disc, gate;
  std::optional<vision::Rect> rectangle;  ///< --template
  std::optional<vision::MarkerChoice> marker;
  std::optional<std::int64_t> first_frame, last_frame;
  std::string layers;  ///< "auto", "on", "off"; empty: auto
};

/// The job: what --config holds, overridden by the rest. Throws UsageError for choices that are out of range
/// or contradict each other, and what reading the file throws.
RecordingJob job_of(const std::filesystem::path& video, const TrackChoices& choices);

}  // namespace tribotrack::apps
