// A finished track, ours or another program's.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "apps/files/campaign/data_section.h"
#include "apps/files/run_folder.h"
#include "apps/files/track_file.h"
#include "apps/files/track_rows.h"
#include "apps/text/csv_table.h"

namespace tribotrack::apps {

/// T.csv with its meta file, or a table that read_foreign_track() knows. A file is ours where it has a meta
/// file beside it, or a column `status`. Throws InvalidInput.
Track read_any_track(const std::filesystem::path& path, const TrackReading& reading);

/// The same, written as T.csv with its meta file, ours byte for byte: what is measured from it is the same.
/// `inputs` of the result is the file written.
Track import_track(const std::filesystem::path& path, const TrackReading& reading,
                   const std::filesystem::path& csv);

// A track of another program as one of ours.

/// Rows as T.csv holds them, and the meta file beside it. Lengths are taken as they stand: what is in pixels
/// keeps pixels and a scale, anything else has millimetres alone. Without a mark the positions are in the
/// camera's frame, as ours are without a marker.
struct ForeignTrack {
  TrackRows rows;
  MetaFile meta;
};

/// Reads a table of another program. Empty cells and NaN are frames where the part was not seen. Times come
/// from the frame rate where one is given, else from the file; those printed with few digits are put back on
/// the even grid that they were rounded from. Standard deviations that the file does not hold are estimated
/// from the scatter from point to point (fit::point_noise). `text` is the file's content; `path` stands in
/// messages. Throws InvalidInput with file, line, column and remedy.
ForeignTrack read_foreign_track(const std::filesystem::path& path, std::string text,
                                const TrackReading& reading);

// Which column of another program's track is what.

/// The columns of one tracked point.
struct PointColumns {
  std::string name;  ///< as the file has it: "mass_A", "pt2", "Trajectory 1"; may be empty
  std::size_t x = 0, y = 0;
  std::optional<std::size_t> x_sd, y_sd;
  std::string unit;  ///< of all four: "px", "mm", ...; empty: its column does not say
};

struct TrackColumns {
  std::string layout;  ///< "Tracker", "Kinovea", "DLTdv", "trackpy", "DICe" or "t, x, y"
  std::optional<std::size_t> frame, time, particle;
  double second = 1;  ///< of the time column
  std::vector<PointColumns> points;
  std::string usual_unit;      ///< of a layout whose columns never say; empty: none is usual
  std::string y;               ///< where the layout tells, as TrackReading
  bool no_sd_is_lost = false;  ///< a frame whose sd is not above 0 was not measured
  bool by_section = false;     ///< rows of several points follow each other, each under its comment
};

/// A track of another program, at its header.
CsvTable track_table(const std::filesystem::path& path, std::string text);

/// Reads the header: the line above the numbers that names an x and a y. Layouts, as their programs write
/// them:
///   Tracker   a line with the track's name, then `t x y` (several tracks: `#multi:`, a line of names above
///             their columns; `t_{1} x_{1} y_{1}`); world coordinates, y up, in a unit that the file does not
///             name
///   Kinovea   `Time (ms)`, then `NAME X`, `NAME Y`; or `#T X Y` over blocks of rows, in ms or h:mm:ss:cc; y
///   up DLTdv     `pt1_cam1_X,pt1_cam1_Y,...`, a line a frame, pixels; y up to version 5, down from version 8
///   on trackpy   a line for each particle and frame: `y,x,...,frame,particle`, pixels, y down TrackMate
///   likewise `TRACK_ID,POSITION_X,POSITION_Y,POSITION_T,FRAME`, with units in a line below; y down ImageJ `X
///   Y Slice` of results, `Track n Slice n X Y` of manual tracking, pixels, y down DICe
///   `FRAME,COORDINATE_X,COORDINATE_Y,DISPLACEMENT_X,DISPLACEMENT_Y,...,SIGMA,...`, pixels, y down others a
///   time or frame and x, y, with units in the names or below: `t_s,x_mm,y_mm`, `time (s),x (px)`;
///             more points as `NAME_x_mm`, `x_1`, `point A: x`, the platform's mark as `marker_x_mm`; sds as
///             `x_sd_mm`
/// Throws InvalidInput where there is none, saying what the table holds.
TrackColumns read_track_columns(const CsvTable& table);

// One tracked point of another program's file, frame by frame, in the file's own unit.

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
