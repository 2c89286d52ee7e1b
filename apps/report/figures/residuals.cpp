#include "apps/report/figures/residuals.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "apps/page/text.h"
#include "apps/report/figures/figures.h"

namespace tribotrack::apps {
namespace {

/// dx and dy made independent of each other are the two numbers that a displacement is; alpha and v are the
/// same two seen otherwise and would show them twice.
bool shown_apart(const std::string& observable) {
  return observable != "alpha_rad" && observable != "v_mm_s";
}

struct Shown {
  std::string observable;
  Series points;
};

}  // namespace

std::vector<Figure> residual_figures(const ReportData& data) {
  std::vector<Shown> kinds;
  double largest = 3;
  for (std::size_t i = 0; i < data.runs.size(); ++i) {
    const auto& all = data.runs[i].residuals;
    const bool vector = std::ranges::any_of(all, [](const auto& r) { return shown_apart(r.observable); });
    for (const ReportResidual& r : all) {
      if (vector && !shown_apart(r.observable)) continue;
      auto kind = std::ranges::find(kinds, r.observable, &Shown::observable);
      if (kind == kinds.end()) {
        Series points{.mark = Mark::points};
        points.colour = static_cast<int>(kinds.size());
        points.name = observable_text(r.observable).substr(0, observable_text(r.observable).find(" ("));
        points.in_legend = true;
        kind = kinds.insert(kinds.end(), {r.observable, points});
      }
      const double beside = 0.18 * (static_cast<double>(kind - kinds.begin()) - 0.5);
      kind->points.x.push_back(static_cast<double>(i + 1) + beside);
      kind->points.y.push_back(r.standardised);
      kind->points.notes.push_back(fmt::format("{}: measured {}, model {}, sd {}", run_label(data, i),
                                               number(r.measured, 6), number(r.modelled, 6),
                                               number(r.sd, 2)));
      if (std::isfinite(r.standardised)) largest = std::max(largest, 1.1 * std::abs(r.standardised));
    }
  }
  const auto judged =
      std::ranges::count_if(data.runs, [](const ReportRun& run) { return !run.residuals.empty(); });
  if (judged < 2) return {};
  const auto count = static_cast<double>(data.runs.size());
  FigurePanel panel{.x = {.title = "run", .low = 0.4, .high = count + 0.6},
                    .y = {.title = "residual, σ", .low = -largest, .high = largest},
                    .stripes = {{-2, 2}},
                    .zero_line = true};
  const std::size_t step = (data.runs.size() + 23) / 24;
  for (std::size_t i = 0; i < data.runs.size(); i += step) {
    panel.x.ticks.push_back(static_cast<double>(i + 1));
    panel.x.labels.push_back(std::to_string(i + 1));
  }
  for (Shown& kind : kinds) panel.series.push_back(std::move(kind.points));
  Figure figure{
      .id = "residuals", .title = "Residuals, run by run", .caption = "", .panels = {panel}, .height = 0.36};
  figure.caption =
      "Measured minus modelled, in standard deviations; the numbers are those of the table of runs. Each run "
      "has as many "
      "marks as degrees of freedom: dx and dy of its displacement are made independent of each other first. "
      "If the model "
      "and the errors are right, 19 of 20 lie in the grey stripe (±2 σ) and show no trend.";
  figure.alternative = fmt::format("Residuals of {} runs in standard deviations; the largest is {}.",
                                   data.runs.size(), number(largest / 1.1, 2));
  return {figure};
}

}  // namespace tribotrack::apps
