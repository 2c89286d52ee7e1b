// One tracked point of another program's file, frame by frame, in the file's own unit.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "apps/files/tracks/any_track.h"

namespace tribotrack::apps {

/// One row's; NaN where the point was not seen, and of the sds where the file has none.
struct PointSample {
  double x = std::numeric_limits<double>::quiet_NaN(), y = x, x_sd = x, y_sd = x;
  bool seen() const { return !std::isnan(x); }
  Eigen::Vector2d place() const { return {x, y}; }
};

struct PointSamples {
  std::string name, unit;
  std::vector<std::int64_t> frame;  ///< the file's, else its rows counted from 0
  std::vector<double> time;         ///< s; empty where the file has no times
  /// The last digits printed: of times, s, and of x and y.
  double time_step = std::numeric_limits<double>::infinity(), step = time_step;
  bool has_sd = false;
  std::vector<PointSample> at;
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
