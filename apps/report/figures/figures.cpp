#include "apps/report/figures/figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>

#include "apps/figures/axes.h"
#include "apps/page/text.h"
#include "apps/report/data/curves.h"
#include "apps/report/figures/parameters.h"
#include "apps/report/figures/runs.h"
#include "model/alpha_v.h"

namespace tribotrack::apps {

std::vector<Figure> campaign_figures(const ReportData& data) {
  std::vector<Figure> figures;
  const auto add = [&](std::vector<Figure> more) { std::ranges::move(more, std::back_inserter(figures)); };
  add(dependence_figures(data));
  add(trajectory_figures(data));
  add(residual_figures(data));
  add(parameter_figures(data));
  add(slide_figures(data));
  for (Figure& figure : figures) settle_axes(figure);
  return figures;
}

std::vector<Figure> run_figures(const ReportData& data, std::size_t index) {
  std::vector<Figure> figures = figures_of_run(data, index);
  for (Figure& figure : figures) settle_axes(figure);
  return figures;
}

std::string run_label(const ReportData& data, std::size_t index) {
  return fmt::format("{} {}", index + 1, data.runs[index].name);
}

namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kTurn = 2 * kPi;
constexpr double kTwoSided95 = 1.96;

/// One of the four.
struct Dependence {
  const char* id;
  bool over_phi;
  bool of_alpha;
  const char* title;
  const char* place;  ///< in the paper
};

constexpr Dependence dependences[] = {
    {"alpha-phi", true, true, "Direction against the phase of the friction pulse", "paper, figure 9a"},
    {"alpha-dtau", false, true, "Direction against the width of the friction pulse", "paper, figure 9b"},
    {"v-phi", true, false, "Mean velocity against the phase of the friction pulse", ""},
    {"v-dtau", false, false, "Mean velocity against the width of the friction pulse", "paper, figure 10"},
};

double shown_x(const ReportRun& run, const Dependence& figure) {
  return figure.over_phi ? phi_in_one_turn(run.phi_rad) : run.dtau_rad;
}

Series measured(const ReportData& data, const ReportGroup& group, const Dependence& figure) {
  Series points{.mark = Mark::points};
  for (const std::size_t i : group.runs) {
    const ReportRun& run = data.runs[i];
    points.x.push_back(shown_x(run, figure));
    points.y.push_back(figure.of_alpha ? run.alpha_rad : run.v_mm_s);
    points.sd.push_back(figure.of_alpha ? run.alpha_sd_rad : run.v_sd_mm_s);
    points.notes.push_back(run_label(data, i));
  }
  return points;
}

/// In standard deviations of the measurement.
Series residual(const ReportData& data, const ReportGroup& group, const Dependence& figure) {
  Series points{.mark = Mark::points};
  for (const std::size_t i : group.runs) {
    const ReportRun& run = data.runs[i];
    double difference = run.v_mm_s - run.modelled_v_mm_s, sd = run.v_sd_mm_s;
    if (figure.of_alpha) {
      difference = model::wrap_angle(run.alpha_rad - run.modelled_alpha_rad);
      sd = run.alpha_sd_rad;
    }
    points.x.push_back(shown_x(run, figure));
    points.y.push_back(difference / sd);
    points.notes.push_back(run_label(data, i));
  }
  return points;
}

/// A curve of angles in [0, 2 pi), broken where it starts again at the other end, with its band.
struct Curve {
  std::vector<double> x, y, half_width;
  void add(double at, double value, double half) {
    x.push_back(at);
    y.push_back(value);
    half_width.push_back(half);
  }
};

Curve curve_of(const ReportGroup& group, const Dependence& figure) {
  Curve curve;
  const std::vector<double>& y = figure.of_alpha ? group.curve_alpha_rad : group.curve_v_mm_s;
  const std::vector<double>& sd = figure.of_alpha ? group.curve_alpha_sd_rad : group.curve_v_sd_mm_s;
  for (std::size_t i = 0; i < group.curve_x_rad.size(); ++i) {
    const double half = i < sd.size() ? kTwoSided95 * sd[i] : kNone;
    if (figure.of_alpha && i > 0 && std::abs(y[i] - y[i - 1]) > kPi) {
      // Upwards through 2 pi, or downwards through 0: where along x, on the straight line between the two.
      const bool upwards = y[i] < y[i - 1];
      const double to = y[i] + (upwards ? kTurn : -kTurn), edge = upwards ? kTurn : 0;
      const double share = to == y[i - 1] ? 1 : (edge - y[i - 1]) / (to - y[i - 1]);
      const double at = group.curve_x_rad[i - 1] + share * (group.curve_x_rad[i] - group.curve_x_rad[i - 1]);
      curve.add(at, edge, half);
      curve.add(at, kNone, kNone);
      curve.add(at, kTurn - edge, half);
    }
    curve.add(group.curve_x_rad[i], y[i], half);
  }
  return curve;
}

/// Directions in [0, 2 pi) as they are, or about a middle where all lie within less than a turn: no needless
/// break at 0.
void settle_alpha_axis(FigurePanel& panel) {
  std::vector<double> values;
  for (const Series& series : panel.series)
    for (std::size_t i = 0; i < series.y.size(); ++i) {
      const double bar = i < series.sd.size() && std::isfinite(series.sd[i]) ? series.sd[i] : 0;
      values.push_back(series.y[i] - bar);
      values.push_back(series.y[i] + bar);
    }
  const Range reach = range_of(values);
  const Range shown = reach.size() > kPi
                          ? Range{std::min(reach.low, -0.12), std::max(reach.high, kTurn + 0.12)}
                          : Range{reach.low - std::max(0.08 * reach.size(), 0.1),
                                  reach.high + std::max(0.08 * reach.size(), 0.1)};
  panel.y = angle_axis("displacement angle α, rad", shown.low, shown.high);
}

std::string band_text(bool band, bool any_sd, std::size_t groups) {
  if (band) return " The band around each line is the model’s 95 % interval by the parameters’ covariance.";
  if (!any_sd || groups <= kMostInLegend) return "";
  return fmt::format(
      " With {} groups colour tells the value they share, and the model’s 95 % bands, which would cover each "
      "other, are left out.",
      groups);
}

Figure figure_of(const ReportData& data, const Dependence& which, const std::vector<ReportGroup>& groups) {
  const bool many = groups.size() > kMostInLegend;
  Figure figure{.id = which.id, .title = which.title, .caption = "", .shared_x = true, .height = 0.86};
  if (*which.place) figure.title += fmt::format(" ({})", which.place);
  FigurePanel main, below;
  main.height = 3;
  std::vector<double> xs, shared;
  bool any_sd = false;
  for (std::size_t g = 0; g < groups.size(); ++g) {
    const ReportGroup& group = groups[g];
    const std::string name = (which.over_phi ? "Δτ = " : "φ = ") + angle(group.shared_rad);
    const auto dressed = [&](Series series) {
      series.name = many ? "" : name;
      series.colour = static_cast<int>(g);
      if (many) series.value = group.shared_rad;
      return series;
    };
    const Curve curve = curve_of(group, which);
    const bool band =
        std::ranges::any_of(curve.half_width, [](double h) { return std::isfinite(h) && h > 0; });
    any_sd = any_sd || band;
    if (band && !many) {
      Series area = dressed({.mark = Mark::band, .x = curve.x});
      for (std::size_t i = 0; i < curve.x.size(); ++i) {
        area.y.push_back(curve.y[i] - curve.half_width[i]);
        area.y_high.push_back(curve.y[i] + curve.half_width[i]);
      }
      main.series.push_back(area);
    }
    main.series.push_back(dressed({.mark = Mark::line, .x = curve.x, .y = curve.y}));
    Series points = dressed(measured(data, group, which));
    points.in_legend = !many;
    main.series.push_back(points);
    Series left = dressed(residual(data, group, which));
    if (std::ranges::any_of(left.y, [](double y) { return std::isfinite(y); })) below.series.push_back(left);
    xs.insert(xs.end(), points.x.begin(), points.x.end());
    xs.insert(xs.end(), curve.x.begin(), curve.x.end());
    shared.push_back(group.shared_rad);
  }
  std::vector<double> measured_at;
  for (const ReportGroup& group : groups)
    for (const std::size_t i : group.runs) measured_at.push_back(shown_x(data.runs[i], which));
  const Range across = padded(range_of(xs), 0.03);
  const FigureAxis x = angle_axis(which.over_phi ? "phase shift φ, rad" : "pulse width Δτ, rad", across.low,
                                  across.high, measured_at);
  main.x = below.x = x;
  main.y = {.title = "mean velocity v, mm/s"};
  if (which.of_alpha) {
    settle_alpha_axis(main);
  } else {
    Range reach{0, 0};
    for (const Series& series : main.series) reach = hull(reach, range_of(series.y));
    main.y.low = std::min(0.0, reach.low);
    main.y.high = 1.08 * reach.high;
  }
  figure.panels = {main};
  if (!below.series.empty()) {
    double largest = 3;
    for (const Series& series : below.series)
      for (const double y : series.y)
        if (std::isfinite(y)) largest = std::max(largest, 1.1 * std::abs(y));
    below.y = {.title = "residual, σ", .low = -largest, .high = largest};
    if (largest < 6)
      for (int tick = largest < 4 ? -2 : -4; tick <= 4 && tick < largest; tick += 2) {
        below.y.ticks.push_back(tick);
        below.y.labels.push_back(tick < 0 ? fmt::format("−{}", -tick) : std::to_string(tick));
      }
    below.stripes = {{-2, 2}};
    below.zero_line = true;
    figure.panels.front().x.shown = false;
    figure.panels.push_back(below);
  }
  if (many) {
    const Range ends = range_of(shared);
    const FigureAxis scale = angle_axis("", ends.low, ends.high, {});
    figure.colours = ColourScale{.title = which.over_phi ? "pulse width Δτ, rad" : "phase shift φ, rad",
                                 .low = ends.low,
                                 .high = ends.high,
                                 .ticks = scale.ticks,
                                 .labels = scale.labels};
  }
  std::string caption =
      which.of_alpha && which.over_phi ? "α is the angle of the displacement, counter-clockwise from the "
                                         "platform’s x axis; it starts again at 0 "
                                         "after a full turn. "
      : which.over_phi
          ? "On a platform that moves in a true circle the model’s steady velocity does not depend on φ. "
          : "";
  caption +=
      "Points: measured, with one standard deviation; lines: the model at the fitted parameters. Below: "
      "measured minus "
      "modelled in standard deviations of the measurement; 19 of 20 are expected in the grey stripe.";
  figure.caption = caption + band_text(any_sd && !many, any_sd, groups.size());
  std::size_t runs = 0;
  for (const ReportGroup& group : groups) runs += group.runs.size();
  figure.alternative =
      fmt::format("{}: {} runs in {} group{}, with the fitted model and the residuals below.", which.title,
                  runs, groups.size(), groups.size() == 1 ? "" : "s");
  return figure;
}

}  // namespace

std::vector<Figure> dependence_figures(const ReportData& data) {
  std::vector<Figure> figures;
  for (const Dependence& which : dependences) {
    const std::vector<ReportGroup>& groups = which.over_phi ? data.over_phi : data.over_dtau;
    if (!groups.empty()) figures.push_back(figure_of(data, which, groups));
  }
  return figures;
}

}  // namespace tribotrack::apps
