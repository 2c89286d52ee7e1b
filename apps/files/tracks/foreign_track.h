// A track of another program as one of ours.
#pragma once

#include <filesystem>
#include <string>

#include "apps/files/campaign/data_section.h"
#include "apps/files/run_folder.h"
#include "apps/files/track_rows.h"

namespace tribotrack::apps {

/// Rows as T.csv holds them, and the meta file beside it. Lengths are taken as they stand: what is in pixels
/// keeps pixels and a scale, anything else has millimetres alone. Without a mark the positions are in the
/// camera's frame, as ours are without a marker.
struct ForeignTrack {
  TrackRows rows;
  MetaFile meta;
};

/// Reads a table of track_columns.h. Empty cells and NaN are frames where the part was not seen. Times come
/// from the frame rate where one is given, else from the file; those printed with few digits are put back on
/// the even grid that they were rounded from. Standard deviations that the file does not hold are estimated
/// from the scatter from point to point (fit::point_noise). `text` is the file's content; `path` stands in
/// messages. Throws InvalidInput with file, line, column and remedy.
ForeignTrack read_foreign_track(const std::filesystem::path& path, std::string text,
                                const TrackReading& reading);

}  // namespace tribotrack::apps
