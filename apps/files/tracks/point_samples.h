// One tracked point of another program's file, frame by frame, in the file's own unit.
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "apps/files/tracks/any_track.h"

namespace tribotrack::apps {

/// A point in one row of the file. NaN: a time where the file has none, a place where the point was not seen,
/// sds where they are still to be estimated.
struct PointSample {
  std::int64_t frame = 0;                                  ///< the file's, else its rows counted from 0
  double time = std::numeric_limits<double>::quiet_NaN();  ///< s
  double x = time, y = time, x_sd = time, y_sd = time;
  double time_step = 0, step = 0;  ///< the last digits printed: of the time, s, and of x and y
  bool seen() const { return !std::isnan(x); }
};

struct PointSamples {
  std::string name, unit;
  bool has_sd = false;  ///< in the file
  std::vector<PointSample> at = {};
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
