#include "apps/report/figures/runs.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "apps/figures/axes.h"
#include "apps/page/text.h"
#include "apps/report/figures/figures.h"

namespace tribotrack::apps {
namespace {

constexpr std::size_t kMostOverTime = 180;  // over time, of each curve
constexpr std::size_t kMostOfOrbit = 200;
constexpr double kTurns = 5;  // standard deviations: less may be chance

/// Stretches of frames in which the part was not measured.
std::vector<Stripe> lost_spans(const ReportRun& run) {
  std::vector<Stripe> spans;
  bool lost = false;
  for (std::size_t i = 0; i < std::min(run.time_s.size(), run.x_mm.size()); ++i) {
    const bool here = !std::isfinite(run.x_mm[i]);
    if (here && !lost) spans.push_back({run.time_s[i], run.time_s[i]});
    if (here) spans.back().high = run.time_s[i + 1 < run.time_s.size() ? i + 1 : i];
    lost = here;
  }
  return spans;
}

Series over_time(const ReportRun& run, const std::vector<double>& y, const char* name, int colour,
                 Mark mark) {
  const std::vector<std::size_t> places = envelope(y, kMostOverTime);
  return {.mark = mark,
          .name = name,
          .x = picked(run.time_s, places),
          .y = picked(y, places),
          .colour = colour,
          .in_legend = true,
          .small = true};
}

/// Measured less modelled, µm, about its mean: where exactly the part was at the start is not known better.
std::vector<double> left_um(const std::vector<double>& measured, const std::vector<double>& modelled) {
  std::vector<double> left(measured.size(), kNone);
  double sum = 0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < std::min(measured.size(), modelled.size()); ++i) {
    left[i] = 1000 * (measured[i] - modelled[i]);
    if (!std::isfinite(left[i])) continue;
    sum += left[i];
    ++count;
  }
  for (double& value : left) value -= count > 0 ? sum / static_cast<double>(count) : 0;
  return left;
}

std::vector<Figure> over_time(const ReportData& data, std::size_t index) {
  const ReportRun& run = data.runs[index];
  if (run.time_s.empty() || run.x_mm.empty()) return {};
  Figure figure{
      .id = fmt::format("run-{}", index + 1), .title = "Over time: " + run_label(data, index), .caption = ""};
  const std::vector<Stripe> lost = lost_spans(run);
  const auto panel = [&](const char* title, std::vector<Series> series, double height = 1) {
    FigurePanel made{
        .x = {.title = "time, s", .shown = false}, .y = {.title = title}, .series = std::move(series)};
    made.height = height;
    made.spans = lost;
    figure.panels.push_back(std::move(made));
  };
  panel("x, y, mm",
        {over_time(run, run.x_mm, "x", 0, Mark::line), over_time(run, run.y_mm, "y", 1, Mark::line)}, 1.6);
  if (!run.model_x_mm.empty()) {
    panel("residual, µm", {over_time(run, left_um(run.x_mm, run.model_x_mm), "x", 0, Mark::points),
                           over_time(run, left_um(run.y_mm, run.model_y_mm), "y", 1, Mark::points)});
    figure.panels.back().zero_line = true;
    for (Series& series : figure.panels.back().series) series.in_legend = false;
  }
  const auto any = [](const std::vector<double>& v) {
    return std::ranges::any_of(v, [](double x) { return std::isfinite(x); });
  };
  if (any(run.sigma_all_px)) {
    panel("σ, px", {over_time(run, run.sigma_all_px, "σ", 2, Mark::points)}, 0.8);
    figure.panels.back().y.low = 0;
    figure.panels.back().y.high = 1.2 * range_of(run.sigma_all_px).high;
  }
  if (any(run.ncc)) panel("NCC score", {over_time(run, run.ncc, "NCC", 3, Mark::points)}, 0.8);
  if (part_turns(run)) panel("rotation θ, rad", {over_time(run, run.theta_rad, "θ", 4, Mark::line)});
  figure.panels.back().x.shown = true;
  figure.shared_x = true;
  figure.height = 0.1 + 0.14 * static_cast<double>(figure.panels.size());
  figure.caption =
      "Position relative to the first frame; σ: standard deviation of a position per axis; NCC: score of the "
      "template, 1 "
      "where it fits exactly.";
  if (!run.model_x_mm.empty())
    figure.caption += " Residual: measured less modelled position at the fitted parameters, about its mean.";
  if (!lost.empty()) figure.caption += " Shaded: the part was not found.";
  if (run.time_s.size() > kMostOverTime)
    figure.caption += fmt::format(
        " Of {} frames at most {} points of each curve are drawn, the lowest and the highest of every "
        "stretch; the table of "
        "the track has all.",
        run.time_s.size(), kMostOverTime);
  figure.alternative =
      fmt::format("Position, residual, sd and score over time of run {}.", run_label(data, index));
  return {figure};
}

/// Every n-th point.
Series dots(const std::vector<double>& x, const std::vector<double>& y) {
  Series series{.mark = Mark::points, .name = "frames", .small = true};
  const std::size_t step = std::max<std::size_t>(1, (x.size() + kMostOfOrbit - 1) / kMostOfOrbit);
  for (std::size_t k = 0; k < std::min(x.size(), y.size()); k += step) {
    series.x.push_back(x[k]);
    series.y.push_back(y[k]);
  }
  return series;
}

Series fitted(std::vector<double> x, std::vector<double> y) {
  return {.mark = Mark::line, .name = "fitted", .x = std::move(x), .y = std::move(y), .colour = 1};
}

std::vector<Figure> platform(const ReportData& data, std::size_t index) {
  const ReportPlatform& p = data.runs[index].platform;
  if (p.orbit_x_mm.empty()) return {};
  Figure figure{.id = fmt::format("platform-{}", index + 1),
                .title = "Platform: " + run_label(data, index),
                .caption = ""};
  FigurePanel orbit{.x = {.title = "ξ, mm"}, .y = {.title = "η, mm"}, .equal_scale = true};
  orbit.series = {dots(p.orbit_x_mm, p.orbit_y_mm), fitted(p.model_x_mm, p.model_y_mm)};
  for (Series& series : orbit.series) series.in_legend = true;
  FigurePanel phase{.x = {.title = "time, s"}, .y = {.title = "phase residual, mrad"}, .zero_line = true};
  phase.series = {dots(p.time_s, p.phase_left_mrad)};
  figure.panels = {orbit, phase};
  if (!p.gate_share.empty()) {
    FigurePanel gate{.x = angle_axis("ωt, rad", 0, 2 * std::numbers::pi),
                     .y = {.title = "lit share", .low = -0.1, .high = 1.1}};
    gate.series = {dots(p.gate_phase_rad, p.gate_share), fitted(p.gate_model_phase_rad, p.gate_model_share)};
    figure.panels.push_back(gate);
  }
  figure.columns = static_cast<int>(figure.panels.size());
  figure.height = figure.columns == 3 ? 0.34 : 0.42;
  figure.caption =
      "The platform’s orbit and the motion fitted to all frames; the phase residual of a constant frequency, "
      "where a bend "
      "is a drift of the drive";
  figure.caption +=
      p.gate_share.empty()
          ? "."
          : "; the lamp’s brightness over the platform’s phase, whose slopes are exposures during which it "
            "switched.";
  figure.alternative =
      fmt::format("Orbit and phase residual of the platform in run {}.", run_label(data, index));
  return {figure};
}

}  // namespace

bool part_turns(const ReportRun& run) {
  if (!run.failure.empty()) return false;
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const double theta : run.theta_rad)
    if (std::isfinite(theta)) {
      low = std::min(low, theta);
      high = std::max(high, theta);
    }
  return high - low > kTurns * run.sigma_theta_rad;
}

std::vector<Figure> figures_of_run(const ReportData& data, std::size_t index) {
  std::vector<Figure> figures = over_time(data, index);
  for (const Figure& more : platform(data, index)) figures.push_back(more);
  return figures;
}

namespace {

constexpr std::size_t kMostOfSlide = 600;

/// What the slide says by itself, its blows included.
std::string own_sentence(const ReportData& data, const std::string& name) {
  for (const ReportSlideResult& slide : data.slide_results)
    if (slide.name == name && !slide.sentence.empty()) return " By itself: " + slide.sentence;
  return "";
}

}  // namespace

std::vector<Figure> slide_figures(const ReportData& data) {
  std::vector<Figure> figures;
  for (std::size_t i = 0; i < data.slides.size(); ++i) {
    const ReportSlide& slide = data.slides[i];
    std::vector<double> left_um;
    for (std::size_t k = 0; k < std::min(slide.position_mm.size(), slide.fitted_mm.size()); ++k)
      left_um.push_back(1000 * (slide.position_mm[k] - slide.fitted_mm[k]));
    const std::vector<std::size_t> places = envelope(left_um, kMostOfSlide);
    const std::vector<double> time = picked(slide.time_s, places);
    FigurePanel main{
        .x = {.title = "time, s", .shown = false}, .y = {.title = "distance, mm"}, .height = 2.4};
    main.series = {{.mark = Mark::points,
                    .name = "measured",
                    .x = time,
                    .y = picked(slide.position_mm, places),
                    .in_legend = true,
                    .small = true},
                   {.mark = Mark::line,
                    .name = "law of friction",
                    .x = time,
                    .y = picked(slide.fitted_mm, places),
                    .colour = 1,
                    .in_legend = true}};
    FigurePanel below{.x = {.title = "time, s"}, .y = {.title = "residual, µm"}, .zero_line = true};
    Series left{.mark = Mark::points, .x = time, .y = picked(left_um, places), .small = true};
    if (!slide.sigma_mm.empty())
      for (const double sigma : picked(slide.sigma_mm, places)) left.sd.push_back(1000 * sigma);
    below.series = {left};
    Figure figure{.id = fmt::format("slide-{}", i + 1), .title = "Free slide " + slide.name, .caption = ""};
    figure.caption =
        "Distance along the slide against time, with the law of friction at its own μ<sub>1</sub> (without "
        "spin a "
        "parabola, deceleration μ<sub>1</sub> g); below, measured minus fitted. " +
        sentence_html(slide.sentence + own_sentence(data, slide.name));
    figure.alternative =
        fmt::format("Free slide {}: distance against time and the residual below.", slide.name);
    figure.panels = {main, below};
    figure.shared_x = true;
    figure.height = 0.5;
    figures.push_back(figure);
  }
  return figures;
}

namespace {

constexpr std::size_t kMostOfPath = 1200;   // per path: 20 cycles keep their loops
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
  const std::size_t most = std::min(kMostOfPath, kMostOfAll / drawn.size());
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
