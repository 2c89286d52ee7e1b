// One tracked point of another program's file, frame by frame, in the file's own unit.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "apps/files/tracks/any_track.h"

namespace tribotrack::apps {

struct PointSamples {
  std::string name, unit;
  std::vector<std::int64_t> frame;  ///< the file's, else its rows counted from 0
  std::vector<double> time;         ///< s; empty where the file has no times
  double time_step = 0;             ///< s, the last digit printed
  double step = 0;                  ///< of x and y, the last digit printed
  std::vector<double> x, y;         ///< NaN where the point was not seen
  std::vector<double> x_sd, y_sd;   ///< empty where the file has none
};

/// The points asked for: the part, and the mark where one is named. A file with several points must be told
/// which is the part; "marker" and "mark" are the mark by their names. Both have the same frames. Throws
/// InvalidInput with file, line and column, and with the names that there are.
struct PartAndMark {
  PointSamples part;
  std::optional<PointSamples> mark;
};
PartAndMark read_points(CsvTable& table, const TrackColumns& columns, const TrackReading& reading);

}  // namespace tribotrack::apps
