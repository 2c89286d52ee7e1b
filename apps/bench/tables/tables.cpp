#include "apps/bench/tables/tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "apps/bench/tables/plot.h"
#include "apps/text/number_text.h"

namespace tribotrack::apps {

namespace {

/// A cell of free text.
std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + "\"";
}

const char* yes(bool value) {
  return value ? "yes" : "no";
}

/// Microseconds or milliseconds, four characters or so.
std::string duration(double seconds) {
  return seconds < 1e-3 ? fmt::format("{:.4g} us", 1e6 * seconds) : fmt::format("{:.4g} ms", 1e3 * seconds);
}

std::string verdict(const model::ModelBenchRow& row) {
  if (row.ours) return "";
  if (!row.finished) return "gave up";
  if (row.time_over_ours == 0) return "PEER WINS: more accurate than any of ours";
  return row.time_over_ours < 1 ? fmt::format("PEER WINS x{:.2f}", 1 / row.time_over_ours)
                                : fmt::format("ours faster x{:.1f}", row.time_over_ours);
}

std::string verdict(const vision::VisionBenchRow& row) {
  if (row.ours) return "";
  const bool closer = row.rms_over_ours < 1, faster = row.time_over_ours < 1;
  if (closer && faster) return "PEER WINS both";
  if (closer) return "PEER WINS on error";
  return faster ? "peer faster" : "";
}

/// The panel called `title`, and in it the series called `name`; made where missing.
PlotSeries& series_in(std::vector<PlotPanel>& panels, const std::string& title, const std::string& name,
                      bool ours) {
  const auto with = [](auto& list, auto member, const std::string& wanted) {
    return std::find_if(list.begin(), list.end(), [&](const auto& item) { return item.*member == wanted; });
  };
  auto panel = with(panels, &PlotPanel::title, title);
  if (panel == panels.end()) panel = panels.insert(panels.end(), {title, {}});
  auto series = with(panel->series, &PlotSeries::name, name);
  if (series == panel->series.end()) series = panel->series.insert(panel->series.end(), {name, {}, ours});
  return *series;
}

}  // namespace

BenchTable table_of(const std::vector<model::ModelBenchRow>& rows) {
  BenchTable table;
  table.csv =
      "scene,method,tolerance,max_step_s,finished,steps,end_x_mm,end_y_mm,error_m,path_error_m,time_s,"
      "repetitions,"
      "time_over_ours,reference\n";
  std::vector<PlotPanel> panels;
  std::string scene;
  for (const auto& row : rows) {
    if (row.scene != scene) {
      scene = row.scene;
      table.text +=
          fmt::format("\n{}\n  {:<45} {:>9} {:>10} {:>9} {:>11} {:>11} {:>11}  at the same error\n", scene,
                      "method", "tolerance", "max step", "steps", "error, m", "of path, m", "time");
    }
    table.csv += fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{},{}\n", quoted(row.scene),
                             quoted(row.method), row.tolerance > 0 ? exact(row.tolerance) : "",
                             row.max_step > 0 ? exact(row.max_step) : "", yes(row.finished), row.steps,
                             exact(row.end.x() * 1e3), exact(row.end.y() * 1e3), exact(row.error),
                             exact(row.path_error), compact(row.time), row.repetitions,
                             compact(row.time_over_ours), quoted(row.reference));
    table.text += fmt::format("  {:<45} {:>9} {:>10} {:>9} {:>11.2g} {:>11.2g} {:>11}  {}\n", row.method,
                              row.tolerance > 0 ? fmt::format("{:g}", row.tolerance) : "-",
                              row.max_step > 0 ? fmt::format("{:g} s", row.max_step) : "-", row.steps,
                              row.error, row.path_error, duration(row.time), verdict(row));
    if (row.finished)
      series_in(panels, row.scene, row.method, row.ours).points.push_back({row.time, row.error});
  }
  table.svg = log_log_svg(panels, "CPU time of 20 cycles, s", "error of the end point, m");
  return table;
}

BenchTable table_of(const std::vector<model::ModelExtremeRow>& rows) {
  BenchTable table;
  table.csv =
      "case,finite,end_x_mm,end_y_mm,steps,stops,time_s,time_per_cycle_over_ordinary,invariant,violation,"
      "allowed,held,derivatives_finite,one_sided,failure\n";
  table.text = fmt::format("\n{:<42} {:>11} {:>9} {:>9} {:>6} {:>7} {:>9} {:>9} {:>8}  {}\n",
                           "stiff and extreme cases", "end, mm", "steps", "time", "x/cyc", "finite",
                           "d finite", "violated", "allowed", "law");
  for (const auto& row : rows) {
    table.csv += fmt::format(
        "{},{},{},{},{},{},{},{},{},{},{},{},{},{},{}\n", quoted(row.name), yes(row.finite),
        exact(row.end.x() * 1e3), exact(row.end.y() * 1e3), row.steps, row.stops, compact(row.time),
        compact(row.ratio_per_cycle), quoted(row.invariant), compact(row.violation), compact(row.allowed),
        yes(row.held), yes(row.derivatives_finite), yes(row.one_sided), quoted(row.failure));
    table.text +=
        fmt::format("{:<42} {:>11.4g} {:>9} {:>9} {:>6.2f} {:>7} {:>9} {:>9.1e} {:>8.1e}  {} {}\n", row.name,
                    row.end.norm() * 1e3, row.steps, duration(row.time), row.ratio_per_cycle, yes(row.finite),
                    row.one_sided ? "one side" : yes(row.derivatives_finite), row.violation, row.allowed,
                    row.held ? "held:" : "BROKEN:", row.failure.empty() ? row.invariant : row.failure);
  }
  return table;
}

BenchTable table_of(const std::vector<model::PlanBenchRow>& rows) {
  BenchTable table;
  table.csv =
      "omission,scene,time_with_s,time_without_s,saving,predicted_saving,error_m,error_bound_m,repetitions\n";
  table.text = fmt::format("\n{:<18} {:>10} {:>10} {:>7} {:>9} {:>9} {:>9}  {}\n", "what omissions save",
                           "with", "without", "saved", "predicted", "error, m", "bound, m", "scene");
  for (const auto& row : rows) {
    const bool comparable = row.error == row.error;
    table.csv += fmt::format("{},{},{},{},{},{},{},{},{}\n", quoted(row.omission), quoted(row.scene),
                             compact(row.time_with), compact(row.time_without), compact(row.saving),
                             compact(row.predicted), comparable ? compact(row.error) : "",
                             compact(row.error_bound), row.repetitions);
    table.text += fmt::format("{:<18} {:>10} {:>10} {:>5.0f} % {:>7.0f} % {:>9} {:>9.1e}  {}\n", row.omission,
                              duration(row.time_with), duration(row.time_without), 100 * row.saving,
                              100 * row.predicted, comparable ? fmt::format("{:.1e}", row.error) : "-",
                              row.error_bound, row.scene);
  }
  return table;
}

BenchTable table_of(const std::vector<model::BatchBenchRow>& rows) {
  BenchTable table;
  table.csv =
      "sweep,wanted,instruction_set,scenarios,share_in_lanes,share_of_lanes_used,time_scalar_s,time_lanes_s,"
      "speedup,sweep_of_a_million_s,difference_amplitudes,repetitions\n";
  table.text =
      fmt::format("\n{:<12} {:<9} {:>9} {:>6} {:>10} {:>10} {:>8} {:>10} {:>10}  {}\n", "many at once",
                  "lanes", "in lanes", "full", "scalar", "lanes", "faster", "a million", "differ", "sweep");
  for (const auto& row : rows) {
    const bool compared = row.speedup == row.speedup;
    table.csv += fmt::format("{},{},{},{},{},{},{},{},{},{},{},{}\n", quoted(row.sweep), row.wanted,
                             row.instruction_set, row.scenarios, compact(row.in_lanes), compact(row.full),
                             compact(row.time_scalar), compact(row.time_lanes), compact(row.speedup),
                             compact(row.million), compact(row.difference), row.repetitions);
    table.text += fmt::format(
        "{:<12} {:<9} {:>7.1f} % {:>4.0f} % {:>10} {:>10} {:>8} {:>8.1f} s {:>10}  {}\n", row.wanted,
        row.instruction_set, 100 * row.in_lanes, 100 * row.full, compared ? duration(row.time_scalar) : "-",
        compared ? duration(row.time_lanes) : "-", compared ? fmt::format("x{:.1f}", row.speedup) : "-",
        row.million, compared ? fmt::format("{:.1e} A", row.difference) : "-", row.sweep);
  }
  return table;
}

BenchTable table_of(const std::vector<model::PaperClaim>& claims) {
  BenchTable table;
  table.csv = "claim,verdict,conditions,quantity,value,unit\n";
  table.text = "\nclaims of the paper (every figure is in the CSV)\n";
  for (const auto& claim : claims) {
    table.text += fmt::format("  {:<14} {} ({})\n{:17}{}\n", to_string(claim.verdict), claim.statement,
                              claim.place, "", claim.finding);
    for (const auto& figure : claim.figures)
      table.csv +=
          fmt::format("{},{},{},{},{},{}\n", quoted(claim.name), to_string(claim.verdict),
                      quoted(figure.conditions), quoted(figure.quantity), compact(figure.value), figure.unit);
  }
  return table;
}

BenchTable table_of(const std::vector<vision::VisionBenchRow>& rows) {
  BenchTable table;
  table.csv =
      "scene,radius_px,noise_levels,method,frames,lost,rms_px,bound_px,rms_over_bound,offset_px,peak_locking_"
      "px,"
      "time_s,rms_over_ours,time_over_ours\n";
  std::vector<PlotPanel> panels;
  std::string scene;
  for (const auto& row : rows) {
    const std::string title = fmt::format("{}, R = {:g} px, noise {:g}", row.scene, row.radius, row.noise);
    if (title != scene) {
      scene = title;
      table.text +=
          fmt::format("\n{} (bound {:.4f} px)\n  {:<32} {:>8} {:>8} {:>8} {:>9} {:>12} {:>5}\n", scene,
                      row.bound, "method", "rms, px", "x bound", "bias, px", "locking", "time/frame", "lost");
    }
    table.csv += fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{},{}\n", quoted(row.scene),
                             exact(row.radius), exact(row.noise), quoted(row.method), row.frames, row.lost,
                             compact(row.rms), compact(row.bound), compact(row.rms / row.bound),
                             compact(row.offset), compact(row.peak_locking), compact(row.time),
                             compact(row.rms_over_ours), compact(row.time_over_ours));
    table.text += fmt::format("  {:<32} {:>8.4f} {:>8.2f} {:>8.4f} {:>9.4f} {:>12} {:>5}  {}\n", row.method,
                              row.rms, row.rms / row.bound, row.offset, row.peak_locking, duration(row.time),
                              row.lost, verdict(row));
    if (row.noise == 2)
      series_in(panels, title, row.method, row.ours).points.push_back({row.time, row.rms / row.bound});
  }
  table.svg = log_log_svg(panels, "CPU time per frame, s", "rms over the Cramer-Rao bound");
  return table;
}

BenchTable table_of(const std::vector<vision::VisionLimitRow>& rows) {
  BenchTable table;
  table.csv =
      "radius_px,texture_levels,noise_levels,layered,components,lost,rms_px,bound_px,rms_over_bound,"
      "standardised_rms,noise_found_levels,time_s\n";
  table.text = fmt::format(
      "\nhow close to the limit `track` is, and how true its standard deviations\n"
      "  {:>8} {:>8} {:>6} {:>8} {:>9} {:>8} {:>13} {:>11} {:>5}\n",
      "R, px", "texture", "noise", "plan", "rms, px", "x bound", "standardised", "time/frame", "lost");
  for (const auto& row : rows) {
    table.csv += fmt::format("{},{},{},{},{},{},{},{},{},{},{},{}\n", exact(row.radius), exact(row.texture),
                             exact(row.noise), yes(row.layered), row.components, row.lost, compact(row.rms),
                             compact(row.bound), compact(row.rms / row.bound), compact(row.standardised),
                             compact(row.noise_found), compact(row.time));
    table.text += fmt::format("  {:>8g} {:>8g} {:>6g} {:>8} {:>9.5f} {:>8.3f} {:>13.3f} {:>11} {:>5}\n",
                              row.radius, row.texture, row.noise, row.layered ? "layered" : "plain", row.rms,
                              row.rms / row.bound, row.standardised, duration(row.time), row.lost);
  }
  return table;
}

BenchTable table_of(const std::vector<vision::VisionDecodingRow>& rows) {
  BenchTable table;
  table.csv =
      "coding,brushed,radius_px,frames,layered,lost,rms_px,decoding_s,tracking_s,tracking_over_decoding\n";
  table.text = fmt::format(
      "\nwhat tracking a recording on disk costs, opening, reading and decoding included\n"
      "  {:<8} {:<8} {:>6} {:>8} {:>9} {:>5} {:>12} {:>12} {:>9} {:>10}\n",
      "coding", "ground", "R, px", "plan", "rms, px", "lost", "decode/frame", "track/frame", "frames/s",
      "x decoding");
  for (const auto& row : rows) {
    table.csv +=
        fmt::format("{},{},{},{},{},{},{},{},{},{}\n", row.coding, yes(row.brushed), exact(row.radius),
                    row.frames, yes(row.layered), row.lost, compact(row.rms), compact(row.decoding),
                    compact(row.tracking), compact(row.tracking / row.decoding));
    table.text +=
        fmt::format("  {:<8} {:<8} {:>6g} {:>8} {:>9.5f} {:>5} {:>12} {:>12} {:>9.0f} {:>10}\n", row.coding,
                    row.brushed ? "brushed" : "plain", row.radius, row.layered ? "layered" : "plain", row.rms,
                    row.lost, duration(row.decoding), duration(row.tracking), 1 / row.tracking,
                    row.coding == "cine" ? "" : fmt::format("{:.2f}", row.tracking / row.decoding));
  }
  return table;
}

BenchTable table_of(const std::vector<fit::FitBenchRow>& rows) {
  BenchTable table;
  table.csv = "data,method,campaigns,converged,time_s,solves,time_over_ours,off_minimum_sd";
  for (const char* name : {"mu1", "mu2", "lag"})
    table.csv += fmt::format(",{0}_rms_error{1},{0}_mean_sd{1},{0}_covered", name,
                             std::string(name) == "lag" ? "_rad" : "_relative");
  table.csv += "\n";
  std::vector<PlotPanel> panels;
  std::string data;
  for (const auto& row : rows) {
    if (row.data != data) {
      data = row.data;
      table.text += fmt::format("\n{:<64} {:>10} {:>7} {:>7} {:>25} {:>15} {:>9}\n", "fits to " + data,
                                "time", "x ours", "conv.", "rms mu1 %, mu2 %, lag", "95 % cover", "off, sd");
    }
    table.csv += fmt::format("{},{},{},{},{},{},{},{}", quoted(row.data), quoted(row.method), row.campaigns,
                             row.converged, compact(row.time), row.solves > 0 ? compact(row.solves) : "",
                             compact(row.time_over_ours), compact(row.off_minimum));
    for (Eigen::Index i = 0; i < 3; ++i)
      table.csv += fmt::format(",{},{},{}", compact(row.rms_error(i)), compact(row.mean_sd(i)),
                               compact(row.covered(i)));
    table.csv += "\n";
    table.text += fmt::format(
        "{:<64} {:>10} {:>7.2f} {:>3}/{:<3} {:>8.4f} {:>7.3f} {:>8.5f} {:>5.2f}{:>5.2f}{:>5.2f} {:>9.1e}\n",
        row.method, duration(row.time), row.time_over_ours, row.converged, row.campaigns,
        100 * row.rms_error(0), 100 * row.rms_error(1), row.rms_error(2), row.covered(0), row.covered(1),
        row.covered(2), row.off_minimum);
    const auto draw = [&](const std::string& what, double value) {
      series_in(panels, row.data + ": " + what, row.method, row.ours).points.push_back({row.time, value});
    };
    draw("rms error of mu1", row.rms_error(0));
    draw("half the 95 % interval of mu1", 1.96 * row.mean_sd(0));
    draw("distance from the minimum, sd", row.off_minimum);
  }
  table.svg = log_log_svg(panels, "CPU time per campaign, s", "relative error; standard deviations");
  return table;
}

BenchTable table_of(const std::vector<fit::CoverageRow>& rows) {
  BenchTable table;
  table.csv = "campaigns,parameter,counted,weak,unusable,covered,covered_by_profile\n";
  table.text = fmt::format("\n{:<24} {:<14} {:>8} {:>6} {:>9} {:>12} {:>12}\n", "95 % intervals hold in",
                           "parameter", "counted", "weak", "unusable", "covariance", "profile");
  for (const auto& row : rows) {
    table.csv += fmt::format("{},{},{},{},{},{},{}\n", quoted(row.kind), row.parameter, row.campaigns,
                             row.weak, row.unusable, compact(row.share()), compact(row.profile_share()));
    table.text +=
        fmt::format("{:<24} {:<14} {:>8} {:>6} {:>9} {:>10.1f} % {:>10.1f} %\n", row.kind, row.parameter,
                    row.campaigns, row.weak, row.unusable, 100 * row.share(), 100 * row.profile_share());
  }
  return table;
}

}  // namespace tribotrack::apps
