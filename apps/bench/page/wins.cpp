#include "apps/bench/page/wins.h"

#include <algorithm>

#include "apps/bench/tables/columns.h"
#include "apps/bench/verdicts/verdicts.h"

namespace tribotrack::bench {
namespace {

const char* const kHeading = "<h3>Where a peer wins</h3>\n";

std::string nowhere(const char* how) {
  return fmt::format("{}<p>Nowhere: {}.</p>\n", kHeading, how);
}

/// Settings of one method on one scene that win.
struct ModelWin {
  std::string scene, method;
  long settings = 0, wins = 0;
  double least_error = 0, largest_error = 0;  ///< m, of those that win
  double gain = 0;                            ///< the largest
  bool more_accurate = false;                 ///< than any of ours, in one of them
};

std::vector<ModelWin> wins_in(const std::vector<ModelBenchRow>& rows) {
  std::vector<ModelWin> wins;
  for (const ModelBenchRow& row : rows) {
    if (row.ours) continue;
    auto win = std::ranges::find_if(
        wins, [&](const ModelWin& w) { return w.scene == row.scene && w.method == row.method; });
    if (win == wins.end()) win = wins.insert(wins.end(), ModelWin{row.scene, row.method});
    ++win->settings;
    if (!peer_wins(row)) continue;
    win->least_error = win->wins == 0 ? row.error : std::min(win->least_error, row.error);
    win->largest_error = std::max(win->largest_error, row.error);
    ++win->wins;
    if (row.time_over_ours == 0)
      win->more_accurate = true;
    else
      win->gain = std::max(win->gain, 1 / row.time_over_ours);
  }
  std::erase_if(wins, [](const ModelWin& win) { return win.wins == 0; });
  return wins;
}

}  // namespace

std::string wins_of_peers(const std::vector<ModelBenchRow>& rows) {
  const std::vector<ModelWin> wins = wins_in(rows);
  if (wins.empty()) return nowhere("at every error of others a setting of ours is as accurate and faster");
  const Columns<ModelWin> columns{
      {"", &ModelWin::scene, "scene", "<"},
      {"", &ModelWin::method, "method", "<"},
      {"", [](const ModelWin& w) { return fmt::format("{} of {}", w.wins, w.settings); }, "settings", "<"},
      {"", &ModelWin::least_error, "at errors from, m", ">9", "{:.2g}"},
      {"", &ModelWin::largest_error, "to, m", ">9", "{:.2g}"},
      {"",
       [](const ModelWin& w) {
         const std::string faster =
             w.gain > 0 ? fmt::format("PEER WINS, up to x{:.2f} faster", w.gain) : "PEER WINS";
         return w.more_accurate ? faster + ", more accurate than any of ours" : faster;
       },
       "by", "<"},
  };
  return kHeading + columns.html("bench_model_wins", wins);
}

std::string wins_of_peers(const std::vector<VisionBenchRow>& rows) {
  using Row = VisionBenchRow;
  std::vector<Row> wins;
  std::ranges::copy_if(rows, std::back_inserter(wins), [](const Row& row) { return peer_wins(row); });
  const auto peers = std::ranges::count(rows, false, &Row::ours);
  const auto faster =
      std::ranges::count_if(rows, [](const Row& row) { return !row.ours && row.time_over_ours < 1; });
  const std::string speed = fmt::format(
      "<p>On speed alone: {} of {} peers take less time than the whole of <code>track</code>.</p>\n", faster,
      peers);
  if (wins.empty()) return nowhere("no peer is closer to the truth than tribotrack on any recording") + speed;
  const Columns<Row> columns{
      {"", &Row::scene, "scene", "<"},
      {"", &Row::radius, "R, px", ">6", "{:g}"},
      {"", &Row::noise, "noise", ">6", "{:g}"},
      {"", &Row::method, "method", "<"},
      {"", &Row::rms_over_ours, "error, x ours", ">6", "{:.2f}"},
      {"", &Row::time_over_ours, "time, x ours", ">6", "{:.3f}"},
      {"", [](const Row& row) { return verdict(row); }, "by", "<"},
  };
  return kHeading + columns.html("bench_vision_wins", wins) + speed;
}

std::string wins_of_peers(const std::vector<FitBenchRow>& rows) {
  using Row = FitBenchRow;
  std::vector<Row> wins;
  std::ranges::copy_if(rows, std::back_inserter(wins), [&](const Row& row) { return peer_wins(row, rows); });
  if (wins.empty()) return nowhere("no peer that finds the same minimum is there sooner than ours");
  const Columns<Row> columns{
      {"", &Row::data, "data", "<"},
      {"", &Row::method, "method", "<"},
      {"", seconds(&Row::time), "time", ">9"},
      {"", [&](const Row& row) { return verdict(row, rows); }, "by", "<"},
  };
  return kHeading + columns.html("bench_fit_wins", wins);
}

}  // namespace tribotrack::bench
