#include <cmath>

#include "apps/bench/figures/figures.h"
#include "apps/bench/tables/columns.h"
#include "apps/bench/tables/tables.h"
#include "apps/bench/verdicts/verdicts.h"

namespace tribotrack::bench {
namespace {

/// For rows that have both.
constexpr auto rms_over_bound = [](const auto& row) { return row.rms / row.bound; };
constexpr auto plan = [](const auto& row) { return row.layered ? "layered" : "plain"; };

}  // namespace

BenchTable table_of(const std::vector<VisionBenchRow>& rows) {
  using Row = VisionBenchRow;
  const Columns<Row> columns{
      {"scene", &Row::scene},
      {"radius_px", exactly(&Row::radius)},
      {"noise_levels", exactly(&Row::noise)},
      {"method", &Row::method, "method", "<32"},
      {"frames", &Row::frames},
      {"lost", &Row::lost},
      {"rms_px", &Row::rms, "rms, px", ">8", "{:.4f}"},
      {"bound_px", &Row::bound},
      {"rms_over_bound", rms_over_bound, "x bound", ">8", "{:.2f}"},
      {"offset_px", &Row::offset, "bias, px", ">8", "{:.4f}"},
      {"peak_locking_px", &Row::peak_locking, "locking", ">9", "{:.4f}"},
      {"time_s", seconds(&Row::time), "time/frame", ">12"},
      {"rms_over_ours", &Row::rms_over_ours},
      {"time_over_ours", &Row::time_over_ours},
      {"", &Row::lost, "lost", ">5"},
      {"", [](const Row& r) { return verdict(r); }, " against ours", "<", " {}"},
  };
  BenchTable table{"bench_vision", columns.csv(rows), "",
                   columns.html("bench_vision", rows, {"scene", "radius_px", "noise_levels"})};
  std::string scene;
  for (const Row& row : rows) {
    const std::string title = fmt::format("{}, R = {:g} px, noise {:g}", row.scene, row.radius, row.noise);
    if (title != scene)
      table.text += fmt::format("\n{} (bound {:.4f} px)\n  {}", scene = title, row.bound, columns.heading());
    table.text += fmt::format("  {}", columns.line(row));
  }
  table.figures = {tracking_figure(rows)};
  return table;
}

BenchTable table_of(const std::vector<VisionLimitRow>& rows) {
  using Row = VisionLimitRow;
  const Columns<Row> columns{
      {"radius_px", exactly(&Row::radius), "R, px", ">8", "{:g}"},
      {"texture_levels", exactly(&Row::texture), "texture", ">8", "{:g}"},
      {"noise_levels", exactly(&Row::noise), "noise", ">6", "{:g}"},
      {"layered", &Row::layered},
      {"", plan, "plan", ">8"},
      {"components", &Row::components},
      {"lost", &Row::lost},
      {"rms_px", &Row::rms, "rms, px", ">9", "{:.5f}"},
      {"bound_px", &Row::bound},
      {"rms_over_bound", rms_over_bound, "x bound", ">8", "{:.3f}"},
      {"standardised_rms", &Row::standardised, "standardised", ">13", "{:.3f}"},
      {"halves", [](const Row& r) { return r.audit.halves(); }, "halves", ">7", "{:.3f}"},
      {"noise_found_levels", &Row::noise_found},
      {"time_s", seconds(&Row::time), "time/frame", ">11"},
      {"", &Row::lost, "lost", ">5"},
  };
  return {"bench_vision_limit", columns.csv(rows),
          fmt::format("\nhow close to the limit `track` is, and how true its standard deviations\n{}",
                      columns.lines(rows, "  ")),
          columns.html("bench_vision_limit", rows)};
}

BenchTable audit_table_of(const std::vector<VisionLimitRow>& rows) {
  using Row = VisionLimitRow;
  const auto audited = [](std::optional<double> vision::Audit::*ratio) {
    return [ratio](const Row& r) { return r.audit.*ratio; };
  };
  const Columns<Row> columns{
      {"radius_px", exactly(&Row::radius), "R, px", ">8", "{:g}"},
      {"texture_levels", exactly(&Row::texture), "texture", ">8", "{:g}"},
      {"noise_levels", exactly(&Row::noise), "noise", ">6", "{:g}"},
      {"frames", [](const Row& r) { return r.audit.frames; }, "frames", ">7"},
      {"halves_x", audited(&vision::Audit::halves_x), "left/right", ">10", "{:.3f}"},
      {"halves_y", audited(&vision::Audit::halves_y), "top/bottom", ">10", "{:.3f}"},
      {"checkerboard", audited(&vision::Audit::checkerboard), "checkerboard", ">12", "{:.3f}"},
      {"high_frequency", audited(&vision::Audit::high_frequency), "frame to frame", ">14", "{:.3f}"},
      {"widened_by", [](const Row& r) { return std::sqrt(r.audit.white_factor); }, "widened by", ">10",
       "{:.3f}"},
      {"standardised_rms", &Row::standardised, "true errors", ">11", "{:.3f}"},
  };
  return {"bench_vision_audit", columns.csv(rows),
          fmt::format("\nwhat the recordings themselves say of the standard deviations: 1 is right\n{}",
                      columns.lines(rows, "  ")),
          columns.html("bench_vision_audit", rows)};
}

BenchTable table_of(const std::vector<VisionDecodingRow>& rows) {
  using Row = VisionDecodingRow;
  const Columns<Row> columns{
      {"coding", bare(&Row::coding), "coding", "<8"},
      {"brushed", &Row::brushed},
      {"", [](const Row& r) { return r.brushed ? "brushed" : "plain"; }, "ground", "<8"},
      {"radius_px", exactly(&Row::radius), "R, px", ">6", "{:g}"},
      {"frames", &Row::frames},
      {"layered", &Row::layered},
      {"", plan, "plan", ">8"},
      {"lost", &Row::lost},
      {"rms_px", &Row::rms, "rms, px", ">9", "{:.5f}"},
      {"", &Row::lost, "lost", ">5"},
      {"decoding_s", seconds(&Row::decoding), "decode/frame", ">12"},
      {"tracking_s", seconds(&Row::tracking), "track/frame", ">12"},
      {"", [](const Row& r) { return 1 / r.tracking; }, "frames/s", ">9", "{:.0f}"},
      {"tracking_over_decoding", [](const Row& r) { return r.tracking / r.decoding; }},
      // An uncompressed recording has nothing to decode.
      {"",
       [](const Row& r) {
         return r.coding == "cine" ? std::string() : fmt::format("{:.2f}", r.tracking / r.decoding);
       },
       "x decoding", ">10"},
  };
  return {"bench_vision_decoding", columns.csv(rows),
          fmt::format("\nwhat tracking a recording on disk costs, opening, reading and decoding included\n{}",
                      columns.lines(rows, "  ")),
          columns.html("bench_vision_decoding", rows)};
}

BenchTable table_of(const std::vector<WholeCommandRow>& rows) {
  using Row = WholeCommandRow;
  const auto share = [](double CommandShares::*member) {
    return [member](const Row& r) { return Percent{r.shares.*member}; };
  };
  const auto called = [](const Row& r) { return r.layers_off ? "layers off" : "default"; };
  // With one thread; the rest is what the table of times in `track --explain` does not name.
  const Columns<Row> columns{
      {"coding", bare(&Row::coding), "coding", "<6"},
      {"brushed", &Row::brushed},
      {"", [](const Row& r) { return r.brushed ? "brushed" : "plain"; }, "ground", "<8"},
      {"diameter_px", exactly(&Row::diameter), "D, px", ">5", "{:g}"},
      {"width_px", &Row::width},
      {"height_px", &Row::height},
      {"", [](const Row& r) { return fmt::format("{}x{}", r.width, r.height); }, "picture", ">9"},
      {"frames", &Row::frames, "frames", ">6"},
      {"layers_off", &Row::layers_off},
      {"", called, "called", "<10"},
      {"layered", &Row::layered},
      {"", plan, "plan", "<7"},
      {"repetitions", &Row::repetitions},
      {"lost", &Row::lost},
      {"rms_px", &Row::rms, "rms, px", ">8", "{:.5f}"},
      {"matching_rms_px", &Row::matching_rms, "match, px", ">9", "{:.5f}"},
      {"cpu_s", &Row::cpu, "CPU, s", ">7", "{:.3f}"},
      {"wall_s", &Row::wall, "wall, s", ">7", "{:.3f}"},
      {"cpu_two_threads_s", &Row::cpu_two_threads},
      {"wall_two_threads_s", &Row::wall_two_threads, "2 thr.", ">7", "{:.3f}"},
      {"matching_cpu_s", &Row::matching, "match, s", ">8", "{:.3f}"},
      {"reading_cpu_s", &Row::reading, "read, s", ">7", "{:.3f}"},
      {"cpu_over_matching", [](const Row& r) { return r.cpu / r.matching; }, "x match", ">7", "{:.2f}"},
      {"cpu_over_reading", [](const Row& r) { return r.cpu / r.reading; }, "x read", ">7", "{:.2f}"},
      {"share_starting", share(&CommandShares::starting), "start", ">5", "{:.0f}"},
      {"share_hashing", share(&CommandShares::hashing), "hash", ">4", "{:.0f}"},
      {"share_reading", share(&CommandShares::reading), "read", ">4", "{:.0f}"},
      {"share_looking", share(&CommandShares::looking), "look", ">4", "{:.0f}"},
      {"share_registering_part", share(&CommandShares::part), "part", ">4", "{:.0f}"},
      {"share_registering_mark", share(&CommandShares::mark), "mark", ">4", "{:.0f}"},
      {"share_learning", share(&CommandShares::learning), "learn", ">5", "{:.0f}"},
      {"share_measuring", share(&CommandShares::measuring), "measure", ">7", "{:.0f}"},
      {"share_radius", share(&CommandShares::radius), "radius", ">6", "{:.0f}"},
      {"share_rotation", share(&CommandShares::rotation), "rotation", ">8", "{:.0f}"},
      {"share_audit", share(&CommandShares::audit), "audit", ">5", "{:.0f}"},
      {"share_writing", share(&CommandShares::writing), "write", ">5", "{:.0f}"},
      {"share_rest", share(&CommandShares::rest), "rest", ">4", "{:.0f}"},
      {"", &Row::lost, "lost", ">4"},
  };
  return {
      "bench_commands", columns.csv(rows),
      fmt::format("\nwhole commands, from the start of the process to its end: CPU time of one thread, wall "
                  "time of one and two; shares of the wall time in %\n{}",
                  columns.lines(rows, "  ")),
      columns.html("bench_commands", rows)};
}

}  // namespace tribotrack::bench
