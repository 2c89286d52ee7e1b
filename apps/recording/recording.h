// A recording on its way to a track (track.h): how it is to be tracked, what it holds, and whether its track
// is there already.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/files/campaign/campaign.h"
#include "apps/files/track_rows.h"
#include "apps/text/input_file.h"
#include "apps/text/json.h"
#include "vision/frame_source.h"
#include "vision/millimetres.h"
#include "vision/track.h"
#include "vision/tracker.h"

namespace tribotrack::apps {

struct Recording {
  // Given.
  std::filesystem::path video;
  PartSection part;
  CameraSection camera;  ///< its mm_per_px beats a calibration, that a tag, that the part's diameter
  vision::TrackOptions options;

  // Checked. The content of the inputs is taken before they are read: what stands in the meta file of the
  // track is what was tracked.
  std::vector<Input> inputs;  ///< the recording and, where there is one, the calibration
  Json configuration;         ///< effective, for the meta file
  /// What the track depends on: program version, configuration and the bytes of the inputs. A track with this
  /// key in its meta file is current. Empty for frames in memory.
  std::string key;
  InputState state;

  // Tracked.
  /// Still open, for pictures of the track. Frames in memory: given, in place of a file.
  std::shared_ptr<vision::FrameSource> source;
  vision::TrackResult result;
  std::optional<vision::PlaneGeometry> geometry;  ///< nothing where neither scale nor diameter was given
  std::optional<vision::Scale> scale;             ///< of the part's top, where there is a geometry
  TrackRows rows;                                 ///< the table
  const vision::SourceInfo& info() const { return source->info(); }
};

/// That of one run of a campaign; keys of the run override those of [camera].
Recording recording_of(const Campaign& campaign, const CampaignRun& run);

/// A number that `track` can be told, a flag of the command line and a keyword in Python: the key that it
/// gives.
struct TrackFlag {
  const char *flag, *section, *key, *help;
};
inline constexpr std::array<TrackFlag, 8> kTrackNumbers = {
    {{"--fps", "camera", "frame_rate_hz",
      "Rate of recording, frames/s, where the file does not give it reliably"},
     {"--mm-per-px", "camera", "mm_per_px", "Scale, of the platform's plane"},
     {"--disc-diameter-mm", "part", "diameter_mm",
      "Scale by the disc's true diameter; beside another scale a check of it"},
     {"--chamfer-mm", "part", "chamfer_mm",
      "Width of the disc's chamfer seen from above, 0 for a sharp edge: makes the scale by its diameter "
      "sharp"},
     {"--tag-mm", "camera", "tag_mm", "Scale by the side of the tag's black square (--marker tag:...)"},
     {"--height-mm", "part", "height_mm", "Height of the part's top above the marker's plane"},
     {"--working-distance-mm", "camera", "working_distance_mm",
      "Distance from the lens to the marker's plane: corrects the parallax together with --height-mm"},
     {"--xi-axis-rad", "camera", "xi_axis_rad",
      "Direction of the platform's displacement at phase 0 in the picture (x right, y up)"}}};
/// The others that give keys of [camera].
inline constexpr std::array<TrackFlag, 7> kTrackPlaces = {
    {{"--fps-reason", "camera", "frame_rate_reason", ""},
     {"--disc", "camera", "disc_px", ""},
     {"--template", "camera", "template_px", ""},
     {"--gate", "camera", "gate_px", ""},
     {"--marker", "camera", "marker_px", ""},
     {"--marker", "camera", "marker", ""},
     {"--calibration", "camera", "calibration", ""}}};

/// What `track` can be told.
struct TrackChoices {
  std::map<std::string, Json> keys = {{"camera", Json::object()},
                                      {"part", Json::object()}};  ///< by the flags
  std::string calibration, config;                                ///< files
  std::optional<std::int64_t> first_frame, last_frame, frame_step;
  std::string layers;  ///< "auto", "on", "off"; empty: auto
};

/// What --config holds, overridden by the rest. Throws UsageError for choices that are out of range or
/// contradict each other, and what reading the file throws.
Recording recording_of(const std::filesystem::path& video, const TrackChoices& choices);

/// How it is tracked, apart from what its inputs hold: the key's configuration, no file looked at.
Json settings_of(const Recording& recording);

/// With the content of its inputs and its key, of which frames in memory have neither. Throws InvalidInput.
Recording checked(Recording recording);

/// Why the track in csv is not that of a recording just checked: edited, of other settings, of another
/// recording or revision of this program; empty where there is none. Nothing where it is the one.
std::optional<std::string> why_outdated(const std::filesystem::path& csv, const Recording& recording);

/// What the recording itself says against what was given of it. Throws vision::InputError where its frame
/// rate is unknown, with the flag to give, UsageError for a template scaled by a diameter, InvalidInput for
/// another frame rate than the camera's and for a rolling shutter slower than a frame.
void require_trackable(const Recording& recording, const vision::SourceInfo& info);

}  // namespace tribotrack::apps
