#include "apps/report/figures/run.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "apps/figures/axes.h"
#include "apps/figures/thinning.h"
#include "apps/page/text.h"
#include "apps/report/figures/figures.h"

namespace tribotrack::apps {
namespace {

constexpr std::size_t kMostPoints = 180;  // over time, of each curve
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
  const std::vector<std::size_t> places = envelope(y, kMostPoints);
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
  if (run.time_s.size() > kMostPoints)
    figure.caption += fmt::format(
        " Of {} frames at most {} points of each curve are drawn, the lowest and the highest of every "
        "stretch; the table of "
        "the track has all.",
        run.time_s.size(), kMostPoints);
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

}  // namespace tribotrack::apps
