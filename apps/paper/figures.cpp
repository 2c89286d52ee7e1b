// The paper's figures from the sweeps that data/figure*.toml state; the program carries these files.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "apps/page/assets/embedded_assets.h"
#include "apps/page/text.h"
#include "apps/paper/paper.h"
#include "apps/simulating/simulation.h"
#include "apps/simulating/sweep.h"
#include "model/alpha_v.h"

namespace tribotrack::apps {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;

/// A parameter of a scenario as the paper writes it.
struct Symbol {
  const char* parameter;
  const char* symbol;
  const char* unit;  ///< "": a pure number
  const char* quantity;
  bool is_angle() const { return std::string_view(unit) == "rad"; }
};

constexpr Symbol symbols[] = {
    {"mu1", "μ₁", "", "friction coefficient μ₁"},
    {"mu1_over_mu2", "μ₁/μ₂", "", "ratio μ₁/μ₂"},
    {"gravity_m_s2", "g", "m/s²", "gravity g"},
    {"amplitude_mm", "Aₑ", "mm", "amplitude Aₑ"},
    {"omega_rad_s", "ω", "rad/s", "angular frequency ω"},
    {"epsilon_rad", "ε", "rad", "phase shift ε of the axes"},
    {"phi_rad", "φ", "rad", "phase shift φ"},
    {"dtau_rad", "Δτ", "rad", "pulse width Δτ"},
};

const Symbol& symbol_of(const std::string& parameter) {
  return *std::ranges::find(symbols, parameter, &Symbol::parameter);
}

/// "11π/9" for multiples of π/36 and of π/10, else as elsewhere on pages.
std::string angle_text(double rad) {
  for (const long n : {36, 10}) {
    const double whole = std::round(rad * static_cast<double>(n) / std::numbers::pi);
    if (std::abs(rad - whole * std::numbers::pi / static_cast<double>(n)) < 1e-9)
      return multiple_of_pi(std::lround(whole), n);
  }
  return angle(rad);
}

/// "φ = π/4", "Aₑ = 0.28 mm": a parameter and its value in the unit of its name.
std::string setting_text(const std::string& parameter, double value) {
  const Symbol& symbol = symbol_of(parameter);
  if (symbol.is_angle()) return fmt::format("{} = {}", symbol.symbol, angle_text(value));
  return fmt::format("{} = {}{}{}", symbol.symbol, number(value), *symbol.unit ? " " : "", symbol.unit);
}

/// One of data/figure*.toml.
struct Source {
  ScenarioFile file;
  Sweep sweep;  ///< its curves: the last axis runs along a curve, or tells trajectories apart

  const SweepAxis& last() const { return sweep.axes().back(); }
  model::Friction friction() const { return file.scenario.friction; }
};

Source source_of(const std::string& name) {
  const auto carried = paper_scenarios();
  StrictTable table = StrictTable::parse(std::ranges::find(carried, name, &EmbeddedScenario::name)->toml,
                                         fmt::format("data/{}.toml", name));
  const ScenarioFile file = read_scenario_tables(table);
  table.finish();
  return {file, Sweep(file, sweep_axes(file.over))};
}

/// "μ₁ = 0.1, μ₁/μ₂ = 8, g = 9.81 m/s², ...; 20 cycles from rest", plain text, without what is swept and what
/// is `told` elsewhere.
std::string conditions_text(const Source& source, const Notes& told = {}) {
  const model::Scenario& s = source.file.scenario;
  const double values[] = {s.friction.nominal,        s.friction.nominal / s.friction.reduced,
                           s.drive.gravity,           1e3 * s.drive.amplitude,
                           s.drive.angular_frequency, s.drive.phase_shift,
                           s.friction.phase,          s.friction.pulse_width};
  Notes fixed;
  const std::vector<SweepAxis>& axes = source.sweep.axes();
  for (std::size_t k = 0; k < std::size(symbols); ++k)
    if (const char* parameter = symbols[k].parameter;
        std::ranges::find(axes, parameter, &SweepAxis::name) == axes.end() &&
        std::ranges::find(told, parameter) == told.end())
      fixed.push_back(setting_text(parameter, values[k]));
  return fmt::format("{}; {} cycles from {}", fmt::join(fixed, ", "), number(s.cycles),
                     model::to_string(s.start));
}

Json axis_of(const SweepAxis& swept) {
  const Symbol& symbol = symbol_of(swept.name());
  const Range ends = padded({swept.value(0), swept.value(swept.count() - 1)}, 0.03);
  const std::string title =
      *symbol.unit ? fmt::format("{}, {}", symbol.quantity, symbol.unit) : symbol.quantity;
  return symbol.is_angle() ? plot::angle_axis(title, ends.low, ends.high)
                           : plot::axis(title, ends.low, ends.high);
}

// Figures 3, 4, 5 and 11: trajectories in millimetres, both axes to the same scale.

struct Path {
  Values time_s, x_mm, y_mm;
};

Path path_of(const Source& source, std::size_t index) {
  const Columns table =
      columns_of(model::integrate(source.sweep.scenario(index)), source.file.samples_per_cycle);
  const auto column = [&table](std::size_t k) { return std::get<Values>(table[k].second); };
  return {column(0), column(1), column(2)};
}

Panel path_panel(const std::string& title) {
  return {.x = plot::axis("x, mm"), .y = plot::axis("y, mm"), .title = title, .equal_scale = true};
}

/// A panel for each file, or for each value of its first axis of two.
void add_paths(Figure& figure, const Notes& files) {
  for (const std::string& file : files) {
    const Source source = source_of(file);
    const std::size_t count = source.last().count();
    const bool alone = source.sweep.axes().size() == 1;
    for (std::size_t first = 0; first < source.sweep.count(); first += count) {
      const std::string setting =
          alone ? fmt::format("{}, {}", setting_text("phi_rad", source.friction().phase),
                              setting_text("dtau_rad", source.friction().pulse_width))
                : setting_text(source.sweep.axes()[0].name(), source.sweep.value(first, 0));
      Panel panel = path_panel(fmt::format("{}: {}", static_cast<char>('a' + figure.panels.size()), setting));
      Notes numbers;
      for (std::size_t k = 0; k < count; ++k) {
        const Path path = path_of(source, first + k);
        numbers.push_back(std::to_string(k + 1));
        panel.traces.push_back(plot::line(
            fmt::format("({}) {}", k + 1, setting_text(source.last().name(), source.last().value(k))),
            path.x_mm, path.y_mm,
            {.colour = static_cast<int>(k), .legend = figure.panels.empty(), .small = true}));
      }
      panel.traces.push_back(plot::end_numbers(panel.traces, numbers));
      figure.panels.push_back(panel);
    }
    figure.caption = conditions_text(source, alone ? Notes{"phi_rad", "dtau_rad"} : Notes{}) + ".";
  }
}

/// The friction coefficient over the run's time, with upright edges.
Json steps_of_friction(const std::string& name, const model::Scenario& scenario, const plot::Look& look) {
  const model::Friction& friction = scenario.friction;
  const double w = scenario.drive.angular_frequency, end = w * scenario.end_time();
  Values edges = {0}, times, mu;
  for (double pulse = friction.phase; pulse < end; pulse += kTurn)
    for (const double edge : {pulse, pulse + friction.pulse_width})
      if (edge > edges.back() && edge < end) edges.push_back(edge);
  edges.push_back(end);
  for (std::size_t k = 1; k < edges.size(); ++k) {
    times.insert(times.end(), {edges[k - 1] / w, edges[k] / w});
    mu.insert(mu.end(), 2, friction.coefficient((edges[k - 1] + edges[k]) / 2));
  }
  return plot::line(name, times, mu, look);
}

/// Displacement and friction over time, and the trajectory, at constant and at pulsed friction.
void add_displacement(Figure& figure, const Notes& files) {
  constexpr double kClearOfCircle = 0.15;  // of the covered distance: P₁ stands outside of the circle
  const Source source = source_of(files.front());
  Panel displacement{.x = plot::hidden(plot::axis("time, s")),
                     .y = plot::axis("displacement, mm"),
                     .title = "a: displacement and friction over time",
                     .height = 1.3};
  Panel friction{.x = plot::axis("time, s"), .y = plot::axis("μ", 0), .height = 0.55};
  Panel paths = path_panel("b: trajectory");
  paths.height = 2.1;
  for (std::size_t k = 0; k < source.sweep.count(); ++k) {
    const model::Scenario s = source.sweep.scenario(k);
    const Path path = path_of(source, k);
    const bool pulsed = s.friction.pulse_width > 0;
    const std::string name = pulsed ? "μ ≠ const" : "μ = const";
    const int colour = static_cast<int>(k);
    friction.traces.push_back(steps_of_friction(name, s, {.colour = colour}));
    displacement.traces.push_back(plot::line(name, path.time_s, path.x_mm, {.colour = colour}));
    displacement.traces.push_back(
        plot::line(name, path.time_s, path.y_mm, {.colour = colour, .dashed = true}));
    paths.traces.push_back(plot::line(name, path.x_mm, path.y_mm, {.colour = colour, .legend = true}));
    if (!pulsed) continue;
    const Eigen::Vector2d end{path.x_mm.back(), path.y_mm.back()}, before = -kClearOfCircle * end,
                                                                   beyond = 1.06 * end;
    paths.traces.push_back(plot::line("covered distance", {0, end.x()}, {0, end.y()},
                                      {.colour = plot::kInk, .legend = true, .dashed = true}));
    paths.traces.push_back(plot::labels({before.x(), beyond.x()}, {before.y(), beyond.y()}, {"P₁", "P₂"}));
    figure.caption =
        fmt::format("{}. Solid x, dashed y. P₁P₂ = {} mm at α = {} rad.", conditions_text(source),
                    number(end.norm()), number(model::displacement_angle(end)));
  }
  figure.panels = {displacement, friction, paths};
}

// Figures 6, 7, 9 and 10: alpha or v along a parameter.

/// The names of a sweep's curves: by its first axis, or by mu1 where there is one axis only.
Notes curve_names(const Source& source) {
  const SweepAxis& first = source.sweep.axes().front();
  if (source.sweep.axes().size() == 1) return {setting_text("mu1", source.friction().nominal)};
  Notes names;
  for (std::size_t k = 0; k < first.count(); ++k) names.push_back(setting_text(first.name(), first.value(k)));
  return names;
}

/// One panel: alpha or v along the sweep's last axis, from rest and dashed the steady motion. `names`: the
/// figure's curves.
Panel curve_panel(const Source& source, const SweptModel& solved, bool of_alpha, const Notes& names,
                  bool legend) {
  constexpr double kSpare = 0.12;  // rad, above and below the full circle
  Panel panel{.x = axis_of(source.last()),
              .y = of_alpha ? plot::angle_axis("angle α, rad", -kSpare, kTurn + kSpare)
                            : plot::axis("velocity v, mm/s", 0)};
  const std::size_t count = source.last().count();
  Values x;
  for (std::size_t k = 0; k < count; ++k) x.push_back(source.last().value(k));
  auto begin = std::ptrdiff_t{0};
  for (const std::string& name : curve_names(source)) {
    const auto colour = static_cast<int>(std::ranges::find(names, name) - names.begin());
    for (const bool steady : {false, true}) {
      const Values& all = of_alpha ? (steady ? solved.steady_alpha_rad : solved.alpha_rad)
                                   : (steady ? solved.steady_v_mm_s : solved.v_mm_s);
      const Values y(all.begin() + begin, all.begin() + begin + static_cast<std::ptrdiff_t>(count));
      const AngleCurve curve = of_alpha ? broken_at_turns(x, y, {}) : AngleCurve{x, y, {}};
      panel.traces.push_back(
          plot::line(name, curve.x, curve.y,
                     {.colour = colour, .legend = legend && !steady, .dashed = steady, .small = steady}));
    }
    begin += static_cast<std::ptrdiff_t>(count);
  }
  return panel;
}

/// Where v is greatest along each curve from rest, and where the paper has it: figure 6a.
void mark_greatest(Panel& panel) {
  constexpr double kGreatestInPaper = 0.75 * kTurn;  // "increases up to 3 pi/2"
  Values xs, ys;
  for (std::size_t k = 0; k < panel.traces.size(); k += 2) {  // those from rest
    const Values x = plot::values_of(panel.traces[k], "x"), y = plot::values_of(panel.traces[k], "y");
    const auto at = static_cast<std::size_t>(std::ranges::max_element(y) - y.begin());
    xs.push_back(x[at]);
    ys.push_back(y[at]);
  }
  panel.traces.push_back(plot::line("3π/2, the paper’s", {kGreatestInPaper, kGreatestInPaper},
                                    {0, std::ranges::max(ys)}, {.colour = plot::kGrey, .legend = true}));
  panel.traces.push_back(plot::points("greatest v", xs, ys, {.colour = plot::kInk, .legend = true}));
}

/// A panel for each file; the one of most curves names them.
void add_curves(Figure& figure, const Notes& files, bool of_alpha, const Context& context) {
  std::vector<Source> sources;
  for (const std::string& file : files) sources.push_back(source_of(file));
  const auto& most =
      *std::ranges::max_element(sources, {}, [](const Source& s) { return curve_names(s).size(); });
  for (const Source& source : sources) {
    Panel panel =
        curve_panel(source, solve(source.sweep, context), of_alpha, curve_names(most), &source == &most);
    if (sources.size() > 1) panel.title = std::string(1, static_cast<char>('a' + figure.panels.size()));
    figure.caption +=
        fmt::format("{}{}. ", panel.title.empty() ? "" : panel.title + ": ", conditions_text(source));
    figure.panels.push_back(panel);
  }
  figure.caption += "Solid: from rest, as the paper counts; dashed: the steady motion.";
  figure.alternative = fmt::format("{}: {} panel{} of curves from rest and of the steady motion.",
                                   figure.title, sources.size(), sources.size() == 1 ? "" : "s");
}

}  // namespace

std::vector<PaperFigure> paper_figures(const Context& given) {
  Context context = given;
  context.quiet = true;
  std::vector<PaperFigure> figures;
  const auto add = [&](const FigureText& text, Figure figure, const auto& draw, const Notes& files) {
    figure.id = fmt::format("figure{}", text.number);
    draw(figure, files);
    figures.push_back({text, std::move(figure)});
  };
  const auto v = [&](Figure& figure, const Notes& files) { add_curves(figure, files, false, context); };
  const auto alpha = [&](Figure& figure, const Notes& files) { add_curves(figure, files, true, context); };
  add({3, "Figure 3: displacement of the part", "", ""},
      {.title = "Displacement of the part",
       .alternative = "Displacement over time at constant and at pulsed friction, and the two trajectories: "
                      "one ends on a circle, the other walks on.",
       .height = 1.3},
      add_displacement, {"figure3"});
  add({4, "Figure 4: trajectories of the part", "", ""},
      {.title = "Trajectories at three amplitudes",
       .alternative = "Four panels of three trajectories each.",
       .columns = 2,
       .height = 1},
      add_paths, {"figure4a", "figure4b", "figure4c", "figure4d"});
  add({5, "Figure 5: trajectories at different phase shifts",
       "The caption does not say after how many cycles; 20 are taken, as for the mean velocity.", ""},
      {.title = "Trajectories at eight phase shifts",
       .alternative = "Eight trajectories in all directions from one point, at a narrow and at a wide pulse.",
       .columns = 2},
      add_paths, {"figure5"});
  add({6, "Figure 6: mean displacement velocity",
       "The caption gives no μ₁ for a, no Aₑ for b and no ω for c; what is taken for these and for d stands "
       "below the figure.",
       ""},
      {.title = "Mean displacement velocity", .columns = 2, .height = 0.9}, v,
      {"figure6a", "figure6b", "figure6c", "figure6d"});
  mark_greatest(figures.back().panels.front());
  add({7, "Figure 7: displacement angle",
       "The caption gives no Δτ for a, no μ₁ and no φ for b and no ω for c; what is taken for these and for "
       "d stands below the figure.",
       ""},
      {.title = "Displacement angle", .columns = 2, .height = 0.9}, alpha,
      {"figure7a", "figure7b", "figure6c", "figure6d"});  // 7c, 7d: as 6c, 6d
  add({9, "Figure 9: displacement angle, measured",
       "The caption gives no Δτ for a and no φ for b; what is taken stands below the figure.",
       "The dependency of α on φ obtained by the model showed a good agreement with the experimental values"},
      {.title = "Displacement angle, the model’s side", .columns = 2, .height = 0.5}, alpha,
      {"figure9a", "figure9b"});
  add({10, "Figure 10: mean displacement velocity, measured",
       "The caption does not say after how many cycles; 20 are taken, as for figure 6.",
       "A comparison between the modeling and the experiments also showed a good agreement"},
      {.title = "Mean displacement velocity, the model’s side"}, v, {"figure10"});
  add({11, "Figure 11: trajectories, measured",
       "The caption gives neither μ₁, μ₂, φ, Δτ nor the number of cycles: those of figure 9 and 20 cycles "
       "are taken, φ and Δτ over their range.",
       "This nature of the part’s motion was close to the one observed in the modeling results"},
      {.title = "Trajectories, the model’s side",
       .alternative = "Trajectories of the model in four directions at three pulse widths.",
       .columns = 3,
       .height = 0.42},
      add_paths, {"figure11"});
  return figures;
}

}  // namespace tribotrack::apps
