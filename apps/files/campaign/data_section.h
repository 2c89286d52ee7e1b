// [data]: tables of alpha and v whose lines become runs, and how tracks of other programs are to be read.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "apps/text/input_file.h"
#include "apps/text/json.h"
#include "apps/text/strict_toml.h"

namespace tribotrack::apps {

struct Campaign;
struct CampaignRun;

/// What the file of another program's track does not say of itself.
struct TrackReading {
  enum class YAxis { by_unit, up, down };
  std::string unit;          ///< of columns that name none: "px", "um", "mm", "cm", "m"; empty: not known
  YAxis y = YAxis::by_unit;  ///< by_unit: down in pixels, up in lengths
  std::string frame;  ///< "platform" or "camera": whose the positions are; empty: the camera's without a mark
  std::string point, mark;  ///< which of the file's points is the part, and which is fixed to the platform
  std::optional<double> mm_per_px;
  double mm_per_px_sd = 0;
  std::optional<double> frame_rate_hz;  ///< beats the file's times
  double xi_axis_rad = 0;
  std::optional<std::int64_t> first_frame, last_frame;
};

struct DataSection {
  std::vector<std::filesystem::path> tables;  ///< resolved against the campaign's folder
  std::optional<std::filesystem::path> runs;  ///< a table of runs, one to a line
  std::optional<double> alpha_sd, v_sd;       ///< rad, m/s: of every line that has none of its own
  TrackReading tracks;                        ///< for runs that do not say otherwise
};

DataSection read_data(StrictTable& table, const std::filesystem::path& folder);

/// table = "x.csv" or a list.
void read_tables(StrictTable& table, DataSection& data, const std::filesystem::path& folder);
Json written_tables(const DataSection& data);

/// A list of runs, one to a line: keys of [[run]] with the values of its cells.
struct RunList {
  struct Line {
    std::string place;  ///< "runs.csv:4"
    Json keys;
  };
  std::vector<Line> lines;
  std::vector<std::string> unused;  ///< columns of no key
};
/// Columns are keys of [[run]], with any unit of their quantity; `file` or `recording` is `video`. Throws
/// InvalidInput naming file, line and column; `path` stands there for a text that came otherwise.
RunList read_run_list(const std::filesystem::path& path, std::string text);

/// Adds a run for each line of the list, and notes columns of no key.
void add_listed_runs(Campaign& campaign);

/// Reads the tables and adds a run for every point, its repeats pooled (fit::pool_points): lines of the same
/// phi, dtau, A, w, start phase and cycles. A run bears its first line's name, or "alpha_v:7" by the table
/// and its line. Says in Campaign::notes what was pooled and where sds came from. Throws InvalidInput naming
/// file, line and remedy; where a line has no sd and nothing tells it, what could.
void add_table_runs(Campaign& campaign);

}  // namespace tribotrack::apps
