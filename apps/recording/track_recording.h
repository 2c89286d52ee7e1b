// From one recording to its track table: what `track` does once and `run` for every video.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/files/run_folder.h"
#include "apps/files/track_file.h"
#include "apps/program/errors.h"
#include "apps/text/input_file.h"
#include "apps/text/json.h"
#include "vision/frame_source.h"
#include "vision/millimetres.h"
#include "vision/track.h"
#include "vision/tracker.h"

namespace tribotrack::apps {

struct RecordingJob {
  std::filesystem::path video;
  std::optional<double> frame_rate_hz;
  std::string frame_rate_reason;    ///< how the user knows it
  std::optional<double> mm_per_px;  ///< of the platform's plane; beats diameter_mm
  double mm_per_px_sd = 0;
  std::optional<std::filesystem::path> calibration;  ///< of the camera; beats diameter_mm
  std::optional<double> diameter_mm;                 ///< of the part's top
  double diameter_sd_mm = 0;
  std::optional<double> height_mm;            ///< of the part's top above the platform
  std::optional<double> working_distance_mm;  ///< from the lens to the platform; a calibration has its own
  double xi_axis_rad = 0;
  std::optional<double> tag_mm;  ///< side of the tag that is the marker: sets the scale
  double tag_mm_sd = 0;
  double row_time_s = 0;  ///< of a rolling shutter
  vision::TrackOptions track;
};

/// A job and the content of its inputs, taken before they are read: what stands in the meta file of the track
/// is what was tracked.
struct PreparedJob {
  RecordingJob job;
  std::vector<Input> inputs;  ///< the recording and, where there is one, the calibration
  Json configuration;         ///< effective, for the meta file
  /// What the track depends on: program version, configuration and the bytes of the inputs. A track with this
  /// key in its meta file is current.
  std::string key;
  InputState state;
  double hashing_s = 0;  ///< wall time that the inputs' hashes took
};

/// How the recording is tracked, apart from what its inputs hold: the key's configuration, no file looked at.
Json settings_of(const RecordingJob& job);

/// Hashes the recording. Throws InvalidInput.
PreparedJob prepare(RecordingJob job);
/// The same for frames that are in memory already: there is nothing to hash but a calibration, and no key.
PreparedJob prepare_in_memory(RecordingJob job);

/// Several discs may be the part. what() lists them, each with the --disc that chooses it.
class AmbiguousPart : public InvalidInput {
 public:
  AmbiguousPart(const std::string& what, const vision::AmbiguousTarget& question)
      : InvalidInput(what), frame(question.frame), discs(question.discs) {}
  std::int64_t frame;                 ///< the recording's own number: where all of them are seen
  std::vector<vision::Circle> discs;  ///< px
};

struct TrackedRecording {
  std::unique_ptr<vision::FrameSource> source;    ///< still open, for pictures of the track
  vision::TrackResult result;                     ///< its stage times begin with the hashing of the inputs
  std::optional<vision::PlaneGeometry> geometry;  ///< nothing where neither scale nor diameter was given
  std::optional<vision::Scale> scale;             ///< of the part's top, where there is a geometry
  TrackRows rows;                                 ///< the table
  const vision::SourceInfo& info() const { return source->info(); }
};

/// Throws vision::InputError where the recording cannot be tracked, with the flag to give where its frame
/// rate is unknown; InvalidInput where it has changed since it was prepared; AmbiguousPart, before which a
/// picture that numbers the discs is written beside the result `beside` (question_picture()), or none.
TrackedRecording track_recording(const PreparedJob& prepared,
                                 const std::optional<std::filesystem::path>& beside);
/// The same for frames in memory.
TrackedRecording track_recording(const PreparedJob& prepared, std::unique_ptr<vision::FrameSource> source);

/// OUT/x.csv -> OUT/x.discs.png; of standard output, x.discs.png for a recording x.mp4.
std::filesystem::path question_picture(const std::filesystem::path& beside,
                                       const std::filesystem::path& recording);

/// The track as measuring takes it, the same to the last bit as read back from the files of write_track().
/// `inputs` stay empty.
Track track_of(const PreparedJob& prepared, const TrackedRecording& recording);

/// What stands beside T.csv.
MetaFile meta_of(const PreparedJob& prepared, const TrackedRecording& recording);

/// Writes T.csv and T.csv.meta.json. Returns T.csv with its hash.
Input write_track(const std::filesystem::path& csv, const PreparedJob& prepared,
                  const TrackedRecording& recording);

/// Draws the track over its recording (vision/overlay.h) into a file that appears whole or not at all. Throws
/// InvalidInput.
void write_overlay_file(const std::filesystem::path& path, const TrackedRecording& recording);

/// Why a track fails its quality gate, and what to do; empty where it does not.
std::string gate_failure(const RecordingJob& job, const vision::TrackSummary& summary);

/// Summary of the track as JSON (`track --json`, meta file).
Json summary_json(const TrackedRecording& recording);

/// Is csv there with a meta file of this key?
bool is_current(const std::filesystem::path& csv, const std::string& key);

}  // namespace tribotrack::apps
