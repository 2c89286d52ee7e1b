#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>

#include "apps/page/text.h"
#include "apps/report/page/page.h"

namespace tribotrack::apps {
namespace {

constexpr std::size_t kMostParameters = 5;  // panels of a corner picture that can still be read

bool determined(const fit::ParameterEstimate& p) {
  return std::isfinite(p.estimate) && std::isfinite(p.sd) && p.sd > 0;
}

/// "μ₁", with its unit.
std::string axis_title(const fit::ParameterEstimate& p) {
  const ParameterText shown = parameter_text(p.parameter);
  return shown.symbol + (shown.unit.empty() ? "" : ", " + shown.unit);
}

/// Four sd to either side: what profile and ellipses reach.
Json axis_of(const fit::ParameterEstimate& p) {
  double low = p.estimate - 3.2 * p.sd, high = p.estimate + 3.2 * p.sd;
  if (!p.profile.empty()) {
    low = std::min(low, p.profile.front().value);
    high = std::max(high, p.profile.back().value);
  }
  return plot::axis(axis_title(p), low, high);
}

/// Between the points that were looked at: the root of the rise, with the side as its sign, straight from one
/// to the next, which is exact for a parabola.
Json profile_curve(const fit::ParameterEstimate& p, bool legend) {
  const auto root = [&](std::size_t i) {
    return std::copysign(std::sqrt(p.profile[i].rise), p.profile[i].value - p.estimate);
  };
  constexpr int kSteps = 24;
  Values x, y;
  for (std::size_t i = 0; i + 1 < p.profile.size(); ++i)
    for (int k = i == 0 ? 0 : 1; k <= kSteps; ++k) {
      const double share = static_cast<double>(k) / kSteps;
      const double at = root(i) + share * (root(i + 1) - root(i));
      x.push_back(p.profile[i].value + share * (p.profile[i + 1].value - p.profile[i].value));
      y.push_back(at * at);
    }
  return plot::line("profile likelihood", x, y, {.colour = 0, .legend = legend});
}

Panel profile_panel(const fit::ParameterEstimate& p, bool legend) {
  const double level = p.profile_level > 0 ? p.profile_level : 3.84;
  Panel panel{.x = axis_of(p), .y = plot::axis("rise of χ²", 0, 2 * level)};
  Values x, y;
  for (int k = -40; k <= 40; ++k) {
    x.push_back(p.estimate + 0.08 * k * p.sd);
    y.push_back(0.08 * 0.08 * k * k);
  }
  panel.traces.push_back(plot::line("parabola by the covariance", x, y,
                                    {.colour = plot::kGrey, .legend = legend, .dashed = true}));
  if (!p.profile.empty()) {
    panel.traces.push_back(profile_curve(p, legend));
    Values tried, rise;
    for (const fit::ProfilePoint& point : p.profile) {
      tried.push_back(point.value);
      rise.push_back(point.rise);
    }
    panel.traces.push_back(plot::points("profile likelihood", tried, rise, {.colour = 0, .small = true}));
  }
  panel.traces.push_back(plot::line("95 % level", plot::values_of(panel.x, "range"), {level, level},
                                    {.colour = 1, .legend = legend, .small = true}));
  return panel;
}

/// A pair's regions by the covariance, and the estimate.
Panel pair_panel(const fit::ParameterEstimate& a, const fit::ParameterEstimate& b, double r, bool legend) {
  Panel panel{.x = axis_of(a), .y = axis_of(b)};
  if (std::isfinite(r))
    for (const double share : {0.683, 0.95}) {
      const double radius = std::sqrt(-2 * std::log(1 - share)), along = std::sqrt(std::max(0.0, 1 - r * r));
      Values x, y;
      for (int k = 0; k <= 72; ++k) {
        const double t = 2 * std::numbers::pi * k / 72;
        x.push_back(a.estimate + radius * a.sd * std::cos(t));
        y.push_back(b.estimate + radius * b.sd * (r * std::cos(t) + along * std::sin(t)));
      }
      panel.traces.push_back(plot::line(share < 0.9 ? "68 % region" : "95 % region", x, y,
                                        {.legend = legend, .dashed = share < 0.9}));
    }
  panel.traces.push_back(
      plot::points("estimate", {a.estimate}, {b.estimate}, {.colour = 1, .legend = legend}));
  return panel;
}

/// Below the diagonal pairs, on it profiles.
std::vector<Figure> corner(const ReportData& data) {
  std::vector<std::size_t> shown;
  for (std::size_t i = 0; i < data.fit.parameters.size() && shown.size() < kMostParameters; ++i)
    if (determined(data.fit.parameters[i])) shown.push_back(i);
  if (shown.empty()) return {};
  const std::size_t n = shown.size();
  Figure figure{.id = "corner", .title = "Profiles and pairs of parameters"};
  figure.columns = static_cast<int>(n);
  figure.height = n == 1 ? 0.6 : n == 2 ? 0.75 : 0.8;
  figure.width = n == 1 ? 0.45 : n == 2 ? 0.6 : 0.72;
  for (std::size_t row = 0; row < n; ++row)
    for (std::size_t column = 0; column < n; ++column) {
      const fit::ParameterEstimate &a = data.fit.parameters[shown[column]],
                                   &b = data.fit.parameters[shown[row]];
      Panel panel;
      if (row == column)
        panel = profile_panel(a, row == 0);
      else if (row > column)
        panel = pair_panel(a, b,
                           data.fit.correlation(static_cast<Eigen::Index>(shown[row]),
                                                static_cast<Eigen::Index>(shown[column])),
                           row == 1 && column == 0);
      if (row + 1 < n) panel.x = plot::hidden(panel.x);
      figure.panels.push_back(panel);
    }
  figure.caption =
      "On the diagonal: by how much χ² rises when a parameter is held at a value and all others are fitted "
      "again, beside the parabola that the covariance assumes; dots are the values tried. Where the curve "
      "crosses the level the 95 % interval ends. Below: regions that hold each pair with 68 and 95 %, by the "
      "covariance.";
  figure.alternative = "Profile likelihood of each parameter, and the 68 and 95 % regions of each pair.";
  return {figure};
}

/// mu1 over the speeds seen, where the values hold under a law that depends on it.
std::vector<Figure> friction(const ReportData& data) {
  if (data.fit.mu_of_speed.empty()) return {};
  Values speed, mu, low, high;
  for (const fit::FrictionAtSpeed& at : data.fit.mu_of_speed) {
    speed.push_back(1e3 * at.speed);
    mu.push_back(at.mu);
    low.push_back(at.mu - 2 * at.sd);
    high.push_back(at.mu + 2 * at.sd);
  }
  Figure figure{.id = "friction", .title = "Friction against speed", .height = 0.6, .width = 0.45};
  figure.panels = {{.x = plot::axis("sliding speed, mm/s"),
                    .y = plot::axis("friction coefficient outside the pulse"),
                    .traces = {plot::band("two standard uncertainties", speed, low, high, {.legend = true}),
                               plot::line("law", speed, mu, {.legend = true})}}};
  figure.caption = "By the law under which the values hold, over the speeds of these runs.";
  figure.alternative = "The friction coefficient against sliding speed, with its uncertainty.";
  return {figure};
}

/// Runs by their numbers, at most 24 of these written.
Json run_axis(const std::string& title, std::size_t runs) {
  Values places;
  Notes numbers;
  for (std::size_t i = 0; i < runs; i += (runs + 23) / 24) {
    places.push_back(static_cast<double>(i + 1));
    numbers.push_back(std::to_string(i + 1));
  }
  return plot::with_ticks(plot::axis(title, 0.4, static_cast<double>(runs) + 0.6), places, numbers);
}

std::vector<Figure> influence(const ReportData& data) {
  Panel panel{.x = run_axis("run left out", data.runs.size()),
              .y = plot::with_zero_line(plot::axis("change of the parameter, σ")),
              .shapes = {plot::stripe(-1, 1)}};
  for (std::size_t p = 0; p < data.fit.parameters.size(); ++p) {
    const double beside =
        0.15 * (static_cast<double>(p) - 0.5 * static_cast<double>(data.fit.parameters.size() - 1));
    Values x, y;
    Notes notes;
    for (std::size_t i = 0; i < data.runs.size(); ++i) {
      if (p >= data.runs[i].fitted.influence.size()) continue;
      x.push_back(static_cast<double>(i + 1) + beside);
      y.push_back(data.runs[i].fitted.influence[p]);
      notes.push_back(run_label(data, i));
    }
    if (!x.empty())
      panel.traces.push_back(plot::points(parameter_text(data.fit.parameters[p].parameter).symbol, x, y,
                                          {.colour = static_cast<int>(p), .legend = true}, notes));
  }
  if (panel.traces.empty() || panel.traces.front()["x"].size() < 2) return {};
  Figure figure{.id = "influence", .title = "Influence of each run", .panels = {panel}, .height = 0.34};
  figure.caption =
      "By how many of its standard deviations each parameter would change if the run were left out (to first "
      "order). A run far outside the stripe carries the result alone: repeat it.";
  figure.alternative = "Change of each parameter when one run is left out, in standard deviations.";
  return {figure};
}

}  // namespace

std::vector<Figure> parameter_figures(const ReportData& data) {
  if (!data.fitted()) return {};
  std::vector<Figure> figures = corner(data);
  std::ranges::move(friction(data), std::back_inserter(figures));
  std::ranges::move(influence(data), std::back_inserter(figures));
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
  Values x = {}, y = {};
  Notes notes = {};
};

}  // namespace

std::vector<Figure> residual_figures(const ReportData& data) {
  std::vector<Shown> kinds;
  double largest = 3;
  for (std::size_t i = 0; i < data.runs.size(); ++i) {
    const auto& all = data.runs[i].fitted.residuals;
    const bool vector = std::ranges::any_of(all, [](const auto& r) { return shown_apart(r.observable); });
    for (const fit::Residual& r : all) {
      if (vector && !shown_apart(r.observable)) continue;
      auto kind = std::ranges::find(kinds, r.observable, &Shown::observable);
      if (kind == kinds.end()) kind = kinds.insert(kinds.end(), {r.observable});
      const double beside = 0.18 * (static_cast<double>(kind - kinds.begin()) - 0.5);
      kind->x.push_back(static_cast<double>(i + 1) + beside);
      kind->y.push_back(r.standardised);
      kind->notes.push_back(fmt::format("{}: measured {}, model {}, sd {}", run_label(data, i),
                                        number(r.measured, 6), number(r.modelled, 6), number(r.sd, 2)));
      if (std::isfinite(r.standardised)) largest = std::max(largest, 1.1 * std::abs(r.standardised));
    }
  }
  const auto judged =
      std::ranges::count_if(data.runs, [](const ReportRun& run) { return !run.fitted.residuals.empty(); });
  if (judged < 2) return {};
  Panel panel{.x = run_axis("run", data.runs.size()),
              .y = plot::with_zero_line(plot::axis("residual, σ", -largest, largest)),
              .shapes = {plot::stripe(-2, 2)}};
  for (std::size_t k = 0; k < kinds.size(); ++k) {
    const std::string& observable = kinds[k].observable;  // "alpha_rad"
    panel.traces.push_back(plot::points(sentence_html(observable.substr(0, observable.find('_'))), kinds[k].x,
                                        kinds[k].y, {.colour = static_cast<int>(k), .legend = true},
                                        kinds[k].notes));
  }
  Figure figure{.id = "residuals", .title = "Residuals, run by run", .panels = {panel}, .height = 0.36};
  figure.caption =
      "Measured minus modelled, in standard deviations; the numbers are those of the table of runs. Each run "
      "has as many marks as degrees of freedom: dx and dy of its displacement are made independent of each "
      "other first. If the model and the errors are right, 19 of 20 lie in the grey stripe (±2 σ) and show "
      "no trend.";
  figure.alternative = fmt::format("Residuals of {} runs in standard deviations; the largest is {}.",
                                   data.runs.size(), number(largest / 1.1, 2));
  return {figure};
}

}  // namespace tribotrack::apps
