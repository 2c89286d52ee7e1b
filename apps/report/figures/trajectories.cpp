#include "apps/report/figures/trajectories.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "apps/figures/axes.h"
#include "apps/figures/thinning.h"
#include "apps/page/text.h"
#include "apps/report/figures/figures.h"

namespace tribotrack::apps {
namespace {

constexpr std::size_t kMostPoints = 1200;   // per path: 20 cycles keep their loops
constexpr std::size_t kMostOfAll = 30'000;  // in one figure

bool has_path(const ReportRun& run) {
  return run.failure.empty() && !run.x_mm.empty() && run.kind != "free_slide";
}

/// Numbers at the ends of the paths; those that end at the same place share one.
Series end_labels(const ReportData& data, const std::vector<std::size_t>& drawn, double size) {
  Series labels{.mark = Mark::text, .colour = kInk};
  for (const std::size_t i : drawn) {
    const ReportRun& run = data.runs[i];
    for (std::size_t k = run.x_mm.size(); k-- > 0;) {
      if (!std::isfinite(run.x_mm[k]) || !std::isfinite(run.y_mm[k])) continue;
      const double length = std::hypot(run.x_mm[k], run.y_mm[k]);
      const double out = length > 0 ? 1 + 0.05 * size / length : 1;
      const double x = out * run.x_mm[k], y = out * run.y_mm[k];
      std::size_t same = 0;
      while (same < labels.x.size() && std::hypot(labels.x[same] - x, labels.y[same] - y) > 0.03 * size)
        ++same;
      if (same < labels.x.size()) {
        labels.notes[same] += fmt::format(", {}", i + 1);
      } else {
        labels.x.push_back(x);
        labels.y.push_back(y);
        labels.notes.push_back(std::to_string(i + 1));
      }
      break;
    }
  }
  return labels;
}

}  // namespace

std::vector<Figure> trajectory_figures(const ReportData& data) {
  std::vector<std::size_t> drawn;
  for (std::size_t i = 0; i < data.runs.size(); ++i)
    if (has_path(data.runs[i])) drawn.push_back(i);
  if (drawn.empty()) return {};
  const bool many = drawn.size() > kMostInLegend;
  std::vector<double> all, angles;
  for (const std::size_t i : drawn) {
    const ReportRun& run = data.runs[i];
    all.insert(all.end(), run.x_mm.begin(), run.x_mm.end());
    all.insert(all.end(), run.y_mm.begin(), run.y_mm.end());
  }
  const Range reach = range_of(all);
  FigurePanel panel{.x = {.title = "x, mm"}, .y = {.title = "y, mm"}, .equal_scale = true};
  bool modelled = false, marked = false;
  const std::size_t most = std::min(kMostPoints, kMostOfAll / drawn.size());
  for (std::size_t k = 0; k < drawn.size(); ++k) {
    const ReportRun& run = data.runs[drawn[k]];
    const DrawnPath path = thinned(run.x_mm, run.y_mm, most);
    const int colour = static_cast<int>(k);
    const std::string name = many ? "" : run_label(data, drawn[k]);
    panel.series.push_back({.mark = Mark::line,
                            .name = name,
                            .x = path.x,
                            .y = path.y,
                            .colour = colour,
                            .in_legend = !many,
                            .small = true});
    if (!run.model_x_mm.empty()) {
      const DrawnPath line = thinned(run.model_x_mm, run.model_y_mm, most);
      panel.series.push_back({.mark = Mark::line,
                              .name = many ? "model" : name,
                              .x = line.x,
                              .y = line.y,
                              .colour = kInk,
                              .in_legend = many && !modelled,
                              .dashed = true,
                              .small = true});
      modelled = true;
    }
    if (!run.cycle_x_mm.empty()) {
      Series marks{.mark = Mark::points,
                   .name = many ? "whole cycles" : name,
                   .x = run.cycle_x_mm,
                   .y = run.cycle_y_mm,
                   .colour = colour,
                   .in_legend = many && !marked,
                   .small = true};
      for (std::size_t c = 0; c < run.cycle_x_mm.size(); ++c)
        marks.notes.push_back(fmt::format("{}, {} cycle{}", run_label(data, drawn[k]), c, c == 1 ? "" : "s"));
      panel.series.push_back(marks);
      marked = true;
    }
  }
  if (drawn.size() <= 60) panel.series.push_back(end_labels(data, drawn, reach.size()));
  Figure figure{.id = "trajectories", .title = "Trajectories of the part (paper, figure 11)", .caption = ""};
  figure.caption =
      "In millimetres from where each began, y up, both axes to the same scale. The numbers are those of the "
      "table of "
      "runs.";
  if (marked) figure.caption += " Dots: the end of each whole cycle of the platform.";
  if (modelled)
    figure.caption +=
        " Dashed: the model at the fitted parameters, started where the part was, at the platform’s phase "
        "there.";
  figure.alternative =
      fmt::format("Paths of {} runs over the platform, {} mm across.", drawn.size(), number(reach.size(), 2));
  figure.panels = {panel};
  std::vector<double> across, along;
  for (const std::size_t i : drawn) {
    across.insert(across.end(), data.runs[i].x_mm.begin(), data.runs[i].x_mm.end());
    along.insert(along.end(), data.runs[i].y_mm.begin(), data.runs[i].y_mm.end());
  }
  const double aspect = range_of(along).size() / range_of(across).size();
  figure.width = std::clamp(0.72 / aspect, 0.5, 1.0);
  figure.height = std::clamp(aspect + 0.05, 0.35, 1.15);
  return {figure};
}

}  // namespace tribotrack::apps
