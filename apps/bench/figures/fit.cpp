#include <fmt/format.h>

#include "apps/bench/figures/figures.h"
#include "apps/bench/figures/log_log.h"
#include "apps/bench/verdicts/verdicts.h"

namespace tribotrack::bench {
namespace {

constexpr double kHalfWidth = 1.96;  // of a 95 % interval, in standard deviations

LogLogPoint point_of(const FitBenchRow& row, const std::vector<FitBenchRow>& rows, const std::string& panel,
                     double y) {
  return {panel,      row.method,
          row.method, fmt::format("{}, {} of {} converged", row.method, row.converged, row.campaigns),
          row.time,   y,
          row.ours,   peer_wins(row, rows),
          false};
}

}  // namespace

apps::Figure fit_error_figure(const std::vector<FitBenchRow>& rows) {
  std::vector<LogLogPoint> points;
  for (const FitBenchRow& row : rows) {
    points.push_back(point_of(row, rows, row.data + ": rms error of μ₁", row.rms_error(0)));
    points.push_back(
        point_of(row, rows, row.data + ": half the 95 % interval of μ₁", kHalfWidth * row.mean_sd(0)));
  }
  LogLogText text{"fit-error-time", "Error of a fit against run time", "", "CPU time per campaign, s",
                  "relative error of μ₁"};
  text.caption =
      "A point is a method. Where methods lie at one height they found the same minimum, and the noise of "
      "the data "
      "decides how far from the truth it is.";
  return log_log_figure(text, points);
}

apps::Figure fit_minimum_figure(const std::vector<FitBenchRow>& rows) {
  std::vector<LogLogPoint> points;
  for (const FitBenchRow& row : rows) points.push_back(point_of(row, rows, row.data, row.off_minimum));
  LogLogText text{"fit-minimum-time", "Distance from the minimum against run time", "",
                  "CPU time per campaign, s", "distance, standard deviations"};
  text.caption =
      "The farthest any estimate lies from that of tribotrack’s whole fit on the same campaign; that fit "
      "itself lies at 0.";
  return log_log_figure(text, points);
}

}  // namespace tribotrack::bench
