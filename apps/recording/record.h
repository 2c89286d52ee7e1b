// Last: what is kept of a tracked recording: T.csv with its meta file, pictures, a summary.
#pragma once

#include <filesystem>
#include <string>

#include "apps/files/run_folder.h"
#include "apps/files/track_file.h"
#include "apps/recording/recording.h"

namespace tribotrack::apps {

/// What stands beside T.csv.
MetaFile meta_of(const Recording& recording);

/// The track as measuring takes it, the same to the last bit as read back from the files of write_track().
/// `inputs` are those of the recording.
Track track_in(const Recording& recording);

/// Writes T.csv and T.csv.meta.json. Returns T.csv with its hash.
Input write_track(const std::filesystem::path& csv, const Recording& recording);

/// Draws the track over its recording (vision/overlay.h) into a file that appears whole or not at all. Throws
/// InvalidInput.
void write_overlay_file(const std::filesystem::path& path, const Recording& recording);

/// The first analysed frame in which the part is seen, reduced, as it stands in the report.
void write_first_frame(const std::filesystem::path& picture, const Recording& recording);

/// Why a track fails its quality gate, and what to do; empty where it does not.
std::string gate_failure(const Recording& recording);

/// Summary of the track as JSON (`track --json`, meta file).
Json summary_json(const Recording& recording);

}  // namespace tribotrack::apps
