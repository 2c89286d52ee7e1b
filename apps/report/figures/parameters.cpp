#include "apps/report/figures/parameters.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "apps/page/text.h"
#include "apps/report/figures/figures.h"

namespace tribotrack::apps {
namespace {

constexpr std::size_t kMostParameters = 5;  // panels of a corner picture that can still be read
constexpr std::size_t kMostSources = 8;

bool determined(const ReportParameter& p) {
  return std::isfinite(p.estimate) && std::isfinite(p.sd) && p.sd > 0;
}

/// "μ₁", with its unit.
std::string axis_title(const ReportParameter& p) {
  const ParameterText shown = parameter_text(p.name);
  return plain_symbol(p.name) + (shown.unit.empty() ? "" : ", " + shown.unit);
}

/// Four sd to either side: what profile and ellipses reach.
FigureAxis axis_of(const ReportParameter& p) {
  double low = p.estimate - 3.2 * p.sd, high = p.estimate + 3.2 * p.sd;
  if (!p.profile.value.empty()) {
    low = std::min(low, p.profile.value.front());
    high = std::max(high, p.profile.value.back());
  }
  return {.title = axis_title(p), .low = low, .high = high};
}

/// Between the points that were looked at: the root of the rise, with the side as its sign, straight from one
/// to the next, which is exact for a parabola.
Series profile_curve(const ReportParameter& p) {
  Series curve{.mark = Mark::line, .name = "profile likelihood", .colour = 0, .in_legend = true};
  const std::vector<double>& value = p.profile.value;
  const auto root = [&](std::size_t i) {
    return std::copysign(std::sqrt(p.profile.rise[i]), value[i] - p.estimate);
  };
  constexpr int kSteps = 24;
  for (std::size_t i = 0; i + 1 < value.size(); ++i)
    for (int k = i == 0 ? 0 : 1; k <= kSteps; ++k) {
      const double share = static_cast<double>(k) / kSteps;
      const double at = root(i) + share * (root(i + 1) - root(i));
      curve.x.push_back(value[i] + share * (value[i + 1] - value[i]));
      curve.y.push_back(at * at);
    }
  return curve;
}

FigurePanel profile_panel(const ReportParameter& p) {
  FigurePanel panel{.x = axis_of(p), .y = {.title = "rise of χ²"}};
  const double level = std::isfinite(p.profile.level) ? p.profile.level : 3.84;
  panel.y.low = 0;
  panel.y.high = 2 * level;
  Series parabola{.mark = Mark::line,
                  .name = "parabola by the covariance",
                  .colour = kGrey,
                  .in_legend = true,
                  .dashed = true};
  for (int k = -40; k <= 40; ++k) {
    parabola.x.push_back(p.estimate + 0.08 * k * p.sd);
    parabola.y.push_back(0.08 * 0.08 * k * k);
  }
  panel.series.push_back(parabola);
  if (!p.profile.value.empty()) {
    panel.series.push_back(profile_curve(p));
    panel.series.push_back({.mark = Mark::points,
                            .name = "profile likelihood",
                            .x = p.profile.value,
                            .y = p.profile.rise,
                            .colour = 0,
                            .small = true});
  }
  panel.series.push_back({.mark = Mark::line,
                          .name = "95 % level",
                          .x = {panel.x.low, panel.x.high},
                          .y = {level, level},
                          .colour = 1,
                          .in_legend = true,
                          .small = true});
  return panel;
}

Series ellipse(const ReportParameter& a, const ReportParameter& b, double r, double radius, const char* name,
               bool dashed) {
  Series line{.mark = Mark::line, .name = name, .colour = 0, .dashed = dashed};
  const double along = std::sqrt(std::max(0.0, 1 - r * r));
  for (int k = 0; k <= 72; ++k) {
    const double t = 2 * std::numbers::pi * k / 72;
    line.x.push_back(a.estimate + radius * a.sd * std::cos(t));
    line.y.push_back(b.estimate + radius * b.sd * (r * std::cos(t) + along * std::sin(t)));
  }
  return line;
}

/// Below the diagonal pairs, on it profiles.
std::vector<Figure> corner(const ReportData& data) {
  std::vector<std::size_t> shown;
  for (std::size_t i = 0; i < data.parameters.size() && shown.size() < kMostParameters; ++i)
    if (determined(data.parameters[i])) shown.push_back(i);
  if (shown.empty()) return {};
  const std::size_t n = shown.size();
  Figure figure{.id = "corner", .title = "Profiles and pairs of parameters", .caption = ""};
  figure.columns = static_cast<int>(n);
  figure.height = n == 1 ? 0.6 : n == 2 ? 0.75 : 0.8;
  figure.width = n == 1 ? 0.45 : n == 2 ? 0.6 : 0.72;
  const double r68 = std::sqrt(-2 * std::log(1 - 0.683)), r95 = std::sqrt(-2 * std::log(0.05));
  bool named = false;
  for (std::size_t row = 0; row < n; ++row)
    for (std::size_t column = 0; column < n; ++column) {
      const ReportParameter& a = data.parameters[shown[column]];
      const ReportParameter& b = data.parameters[shown[row]];
      FigurePanel panel;
      if (row == column) {
        panel = profile_panel(a);
        if (named)
          for (Series& series : panel.series) series.in_legend = false;
        named = true;
      } else if (row > column && shown[row] < data.correlation.size()) {
        const double r = data.correlation[shown[row]][shown[column]];
        panel = {.x = axis_of(a), .y = axis_of(b)};
        if (std::isfinite(r)) {
          panel.series.push_back(ellipse(a, b, r, r68, "68 % region", true));
          panel.series.push_back(ellipse(a, b, r, r95, "95 % region", false));
        }
        panel.series.push_back(
            {.mark = Mark::points, .name = "estimate", .x = {a.estimate}, .y = {b.estimate}, .colour = 1});
        if (row == 1 && column == 0)
          for (Series& series : panel.series) series.in_legend = true;
      }
      panel.x.shown = row + 1 == n;
      figure.panels.push_back(panel);
    }
  figure.caption =
      "On the diagonal: by how much χ² rises when a parameter is held at a value and all others are fitted "
      "again, beside "
      "the parabola that the covariance assumes; dots are the values tried. Where the curve crosses the "
      "level the 95 % "
      "interval ends. Below: regions "
      "that hold each pair with 68 and 95 %, by the covariance.";
  figure.alternative = "Profile likelihood of each parameter, and the 68 and 95 % regions of each pair.";
  return {figure};
}

std::vector<Figure> budget(const ReportData& data) {
  std::vector<const ReportBudgetEntry*> counted;
  for (const ReportBudgetEntry& entry : data.budget)
    if (entry.counted && counted.size() < kMostSources) counted.push_back(&entry);
  if (counted.empty()) return {};
  Figure figure{.id = "budget-shares", .title = "Uncertainty budget", .caption = ""};
  for (std::size_t i = 0; i < data.parameters.size() && i < kMostParameters; ++i) {
    const ReportParameter& p = data.parameters[i];
    if (!determined(p)) continue;
    FigurePanel panel{.x = {.title = "share of the variance, %", .low = 0, .high = 100},
                      .y = {.low = -0.6, .high = static_cast<double>(counted.size()) - 0.4}};
    Series bars{.mark = Mark::bars, .colour = static_cast<int>(i)};
    for (std::size_t k = 0; k < counted.size(); ++k) {
      const double contribution = i < counted[k]->contribution.size() ? counted[k]->contribution[i] : kNone;
      const double at = static_cast<double>(counted.size() - 1 - k);
      bars.x.push_back(100 * contribution * contribution / (p.sd * p.sd));
      bars.y.push_back(at);
      bars.notes.push_back(counted[k]->source);
      panel.y.ticks.push_back(at);
      panel.y.labels.push_back(counted[k]->source);
    }
    panel.series = {bars};
    panel.title = plain_symbol(p.name);
    panel.y.shown = figure.panels.empty();
    figure.panels.push_back(panel);
  }
  if (figure.panels.empty()) return {};
  figure.columns = static_cast<int>(figure.panels.size());
  figure.height = 0.12 + 0.035 * static_cast<double>(counted.size());
  figure.caption =
      "What each source gives to the variance of each parameter (JCGM 100); the shares add up to 100 %.";
  figure.alternative =
      "Shares of the sources of uncertainty in the variance of each parameter; the table has the numbers.";
  return {figure};
}

std::vector<Figure> influence(const ReportData& data) {
  FigurePanel panel{
      .x = {.title = "run left out", .low = 0.4, .high = static_cast<double>(data.runs.size()) + 0.6},
      .y = {.title = "change of the parameter, σ"},
      .stripes = {{-1, 1}},
      .zero_line = true};
  for (std::size_t p = 0; p < data.parameters.size(); ++p) {
    Series points{.mark = Mark::points,
                  .name = plain_symbol(data.parameters[p].name),
                  .colour = static_cast<int>(p),
                  .in_legend = true};
    for (std::size_t i = 0; i < data.runs.size(); ++i) {
      if (p >= data.runs[i].influence.size()) continue;
      points.x.push_back(
          static_cast<double>(i + 1) +
          0.15 * (static_cast<double>(p) - 0.5 * static_cast<double>(data.parameters.size() - 1)));
      points.y.push_back(data.runs[i].influence[p]);
      points.notes.push_back(run_label(data, i));
    }
    if (!points.x.empty()) panel.series.push_back(points);
  }
  if (panel.series.empty() || panel.series.front().x.size() < 2) return {};
  const std::size_t step = (data.runs.size() + 23) / 24;
  for (std::size_t i = 0; i < data.runs.size(); i += step) {
    panel.x.ticks.push_back(static_cast<double>(i + 1));
    panel.x.labels.push_back(std::to_string(i + 1));
  }
  Figure figure{
      .id = "influence", .title = "Influence of each run", .caption = "", .panels = {panel}, .height = 0.34};
  figure.caption =
      "By how many of its standard deviations each parameter would change if the run were left out (to first "
      "order). A run "
      "far outside the stripe carries the result alone: repeat it.";
  figure.alternative = "Change of each parameter when one run is left out, in standard deviations.";
  return {figure};
}

}  // namespace

std::vector<Figure> parameter_figures(const ReportData& data) {
  if (!data.fitted) return {};
  std::vector<Figure> figures = corner(data);
  for (const auto& more : {budget(data), influence(data)})
    figures.insert(figures.end(), more.begin(), more.end());
  return figures;
}

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
