#include "apps/report/page/page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>

#include "apps/page/text.h"
#include "apps/report/data/curves.h"
#include "model/alpha_v.h"

namespace tribotrack::apps {

std::vector<Figure> campaign_figures(const ReportData& data) {
  std::vector<Figure> figures;
  for (const auto& part :
       {dependence_figures, trajectory_figures, residual_figures, parameter_figures, slide_figures})
    std::ranges::move(part(data), std::back_inserter(figures));
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

/// What the runs of a group measured, beside the model in the standard deviations that chi^2 uses.
struct Measured {
  Values x, y, sd, residual;
  Notes notes;
};

Measured measured(const ReportData& data, const ReportGroup& group, const Dependence& figure) {
  Measured points;
  for (const std::size_t i : group.runs) {
    const ReportRun& run = data.runs[i];
    const char* observable = figure.of_alpha ? "alpha_rad" : "v_mm_s";
    const fit::Estimate seen = run.value(observable);
    const double used_sd = run.residual(observable, &fit::Residual::sd);
    points.x.push_back(angle_over(figure.over_phi ? Over::phi : Over::dtau, run));
    points.y.push_back(seen.value);
    points.sd.push_back(seen.sd);
    const double difference = seen.value - run.modelled(observable);
    points.residual.push_back((figure.of_alpha ? model::wrap_angle(difference) : difference) / used_sd);
    points.notes.push_back(run_label(data, i));
  }
  return points;
}

AngleCurve curve_of(const ReportGroup& group, const Dependence& figure) {
  Values half = figure.of_alpha ? group.curve_alpha_sd_rad : group.curve_v_sd_mm_s;
  for (double& sd : half) sd *= kTwoSided95;
  return figure.of_alpha ? broken_at_turns(group.curve_x_rad, group.curve_alpha_rad, half)
                         : AngleCurve{group.curve_x_rad, group.curve_v_mm_s, half};
}

/// Directions in [0, 2 pi) as they are, or about a middle where all lie within less than a turn: no needless
/// break at 0.
Json alpha_axis(const std::vector<Json>& traces) {
  Values values;
  for (const Json& trace : traces) {
    const Values y = plot::values_of(trace, "y");
    const Values sd = trace.contains("error_y") ? plot::values_of(trace["error_y"], "array") : Values();
    for (std::size_t i = 0; i < y.size(); ++i) {
      const double bar = i < sd.size() && std::isfinite(sd[i]) ? sd[i] : 0;
      values.insert(values.end(), {y[i] - bar, y[i] + bar});
    }
  }
  const Range reach = range_of(values);
  const Range shown = reach.size() > kPi
                          ? Range{std::min(reach.low, -0.12), std::max(reach.high, kTurn + 0.12)}
                          : Range{reach.low - std::max(0.08 * reach.size(), 0.1),
                                  reach.high + std::max(0.08 * reach.size(), 0.1)};
  return plot::angle_axis("displacement angle α, rad", shown.low, shown.high);
}

Figure figure_of(const ReportData& data, const Dependence& which, const std::vector<ReportGroup>& groups) {
  const bool many = groups.size() > kMostInLegend;
  Figure figure{.id = which.id, .title = which.title, .shared_x = true, .height = 0.86};
  if (*which.place) figure.title += fmt::format(" ({})", which.place);
  Values shared;
  for (const ReportGroup& group : groups) shared.push_back(group.shared_rad);
  const Range scale = range_of(shared);
  Panel main, below;
  Values xs, measured_at;
  double largest = 3;  // residual
  for (std::size_t g = 0; g < groups.size(); ++g) {
    const std::string name = many ? "" : (which.over_phi ? "Δτ = " : "φ = ") + angle(shared[g]);
    plot::Look look{.colour = static_cast<int>(g)};
    if (many) look.on_ramp = (shared[g] - scale.low) / scale.size();
    const AngleCurve curve = curve_of(groups[g], which);
    if (!many && std::ranges::any_of(curve.half, [](double half) { return half > 0; })) {
      Values low = curve.y, high = curve.y;
      for (std::size_t i = 0; i < curve.half.size(); ++i) {
        low[i] -= curve.half[i];
        high[i] += curve.half[i];
      }
      main.traces.push_back(plot::band(name, curve.x, low, high, look));
    }
    main.traces.push_back(plot::line(name, curve.x, curve.y, look));
    const Measured points = measured(data, groups[g], which);
    if (std::ranges::any_of(points.residual, [](double y) { return std::isfinite(y); }))
      below.traces.push_back(plot::points(name, points.x, points.residual, look, points.notes));
    look.legend = !many;
    main.traces.push_back(plot::points(name, points.x, points.y, look, points.notes, points.sd));
    xs.insert(xs.end(), points.x.begin(), points.x.end());
    xs.insert(xs.end(), curve.x.begin(), curve.x.end());
    measured_at.insert(measured_at.end(), points.x.begin(), points.x.end());
    for (const double y : points.residual)
      if (std::isfinite(y)) largest = std::max(largest, 1.1 * std::abs(y));
  }
  const Range across = padded(range_of(xs), 0.03);
  main.x = below.x = plot::angle_axis(which.over_phi ? "phase shift φ, rad" : "pulse width Δτ, rad",
                                      across.low, across.high, measured_at);
  main.height = 3;
  if (which.of_alpha) {
    main.y = alpha_axis(main.traces);
  } else {
    Range reach{0, 0};
    for (const Json& trace : main.traces) reach = hull(reach, range_of(plot::values_of(trace, "y")));
    main.y = plot::axis("mean velocity v, mm/s", std::min(0.0, reach.low), 1.08 * reach.high);
  }
  if (below.traces.empty()) {
    figure.panels = {main};
  } else {
    below.y = plot::with_zero_line(plot::axis("residual, σ", -largest, largest));
    below.shapes = {plot::stripe(-2, 2)};
    main.x = plot::hidden(main.x);
    figure.panels = {main, below};
  }
  if (many)
    figure.colour_bar = plot::colour_bar(which.over_phi ? "pulse width Δτ, rad" : "phase shift φ, rad",
                                         plot::angle_axis("", scale.low, scale.high));
  figure.caption =
      which.of_alpha && which.over_phi
          ? "α: counter-clockwise from the platform’s x axis; it starts again at 0 after a full turn."
      : which.over_phi ? "On a true circle the model’s steady velocity does not depend on φ."
                       : "";
  if (many)
    figure.caption +=
        " Colour tells the value that a group shares; bands, which would cover each other, are left out.";
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
