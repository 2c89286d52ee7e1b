// A finished track, ours or another program's.
#pragma once

#include <filesystem>

#include "apps/files/campaign/data_section.h"
#include "apps/files/track_file.h"

namespace tribotrack::apps {

/// T.csv with its meta file, or a table that read_foreign_track() knows. A file is ours where it has a meta
/// file beside it, or a column `status`. Throws InvalidInput.
TrackFile read_any_track(const std::filesystem::path& path, const TrackReading& reading);

/// The same, written as T.csv with its meta file, ours byte for byte: what is measured from it is the same.
/// `inputs` of the result is the file written.
TrackFile import_track(const std::filesystem::path& path, const TrackReading& reading,
                       const std::filesystem::path& csv);

}  // namespace tribotrack::apps
