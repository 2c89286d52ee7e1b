// [data]: tables of alpha and v whose lines become runs, and how tracks of other programs are to be read.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "apps/files/keys.h"
#include "apps/text/input_file.h"
#include "apps/text/json.h"
#include "apps/text/strict_toml.h"

namespace tribotrack::apps {

struct Campaign;
struct CampaignRun;

// The words of TrackReading's `unit`, `y` and `frame`.
inline const std::vector<std::string> kTrackUnits = {"px", "um", "mm", "cm", "m"};
inline const std::vector<std::string> kTrackY = {"up", "down"};
inline const std::vector<std::string> kTrackFrames = {"platform", "camera"};

/// What the file of another program's track does not say of itself.
struct TrackReading {
  std::string unit;   ///< of columns that name none: one of kTrackUnits; empty: not known
  std::string y;      ///< where it points, "up" or "down"; empty: down in pixels, up in lengths
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
    Digits digits;  ///< of numbers, by the keys that they give, as the cells are written
    std::map<std::string, std::string, std::less<>>
        others;  ///< cells of columns of no key, by their quantity
    std::string other(std::string_view quantity) const {
      const auto found = others.find(quantity);
      return found == others.end() ? "" : found->second;
    }
  };
  std::vector<Line> lines;
  std::vector<std::string> unused;  ///< columns of no key
};
/// Columns are keys of [[run]], or only some of them, with any unit of their quantity; `file` or `recording`
/// is `video`. An sd of 0 is left out: exact. Throws InvalidInput naming file, line and column; `path` stands
/// there for a text that came otherwise.
RunList read_run_list(const std::filesystem::path& path, std::string text,
                      const std::vector<std::string>& only = {});

/// Adds a run for each line of the list, and notes columns of no key.
void add_listed_runs(Campaign& campaign);

/// Adds a run for every point of the tables of alpha and v, its repeats pooled (fit::pool_points): lines of
/// the same phi, dtau, A, w, start phase and cycles. The runs.csv of `run` is such a table: its failed runs
/// and free slides are left out, and where a run has no alpha its dx_mm and dy_mm give it. A run bears its
/// first line's name, or "alpha_v:7" by the table and its line. Says in Campaign::notes what was pooled and
/// where sds came from. Throws InvalidInput naming file, line and remedy; where a line has no sd and nothing
/// tells it, what could.
void add_table_runs(Campaign& campaign);

}  // namespace tribotrack::apps
