#include <fmt/format.h>

#include "apps/bench/figures/figures.h"
#include "apps/bench/figures/log_log.h"
#include "apps/bench/verdicts/verdicts.h"

namespace tribotrack::bench {
namespace {

/// Solvers of one library share an entry of the legend: a dozen colours cannot be told apart.
std::string group_of(const std::string& method) {
  if (method.starts_with("odeint"))
    return method.find("AVX2") != std::string::npos ? "Boost.odeint, AVX2" : "Boost.odeint";
  return method.starts_with("CVODE") ? "SUNDIALS CVODE" : method;
}

std::string note_of(const ModelBenchRow& row) {
  std::string note = row.method;
  if (row.tolerance > 0) note += fmt::format(", tolerance {:g}", row.tolerance);
  if (row.max_step > 0)
    note += fmt::format(", {} {:g} s", row.tolerance > 0 ? "steps up to" : "steps of", row.max_step);
  return note;
}

}  // namespace

apps::Figure model_figure(const std::vector<ModelBenchRow>& rows) {
  std::vector<LogLogPoint> points;
  for (const ModelBenchRow& row : rows) {
    if (!row.finished) continue;
    points.push_back({row.scene, row.method, group_of(row.method), note_of(row), row.time, row.error,
                      row.ours, peer_wins(row), row.method.find("by clock") != std::string::npos});
  }
  LogLogText text{"model-error-time", "Error of the end point against run time", "", "CPU time, s",
                  "error, m"};
  text.caption =
      "A point is a method at one tolerance or step; nearer to the lower left corner is better. Dashed: the "
      "friction is read off the clock inside a step, as in the paper’s recipe, instead of ending a step on "
      "every switch.";
  return log_log_figure(text, points);
}

}  // namespace tribotrack::bench
