// Figures 3, 4, 5 and 11.
#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "apps/figures/axes.h"
#include "apps/page/text.h"
#include "apps/paper/figures.h"
#include "apps/paper/scenarios.h"
#include "model/alpha_v.h"
#include "model/trajectory.h"

namespace tribotrack::apps {
namespace {

constexpr double kLabelBeyondEnd = 0.06;  // of the panel's reach

constexpr double kClearOfCircle =
    0.15;  // of the covered distance: P₁ stands outside of the circle at constant mu

struct Path {
  std::vector<double> time_s, x_mm, y_mm;
};

Path path_of(const model::Scenario& scenario, int samples_per_cycle) {
  const model::Trajectory run = model::integrate(scenario);
  const auto count = static_cast<int>(std::ceil(scenario.cycles * samples_per_cycle));
  Path path;
  for (int k = 0; k <= count; ++k) {
    const model::Sample sample = run.at(k == count ? run.end_time() : run.end_time() * k / count);
    path.time_s.push_back(sample.time);
    path.x_mm.push_back(1e3 * sample.position.x());
    path.y_mm.push_back(1e3 * sample.position.y());
  }
  return path;
}

/// The friction coefficient over the run's time, with upright edges.
Series steps_of_friction(const model::Scenario& scenario) {
  const model::Friction& friction = scenario.friction;
  const double w = scenario.drive.angular_frequency, turn = 2 * std::numbers::pi;
  std::vector<double> edges = {0};
  const double first = friction.phase + friction.lag - scenario.start_phase;
  for (double pulse = first - turn * std::ceil(first / turn); pulse < w * scenario.end_time(); pulse += turn)
    for (const double edge : {pulse, pulse + friction.pulse_width})
      if (edge > 0 && edge < w * scenario.end_time()) edges.push_back(edge);
  edges.push_back(w * scenario.end_time());
  Series steps{.mark = Mark::line};
  for (std::size_t k = 1; k < edges.size(); ++k) {
    const double mu = friction.coefficient(scenario.start_phase + (edges[k - 1] + edges[k]) / 2);
    steps.x.insert(steps.x.end(), {edges[k - 1] / w, edges[k] / w});
    steps.y.insert(steps.y.end(), {mu, mu});
  }
  return steps;
}

FigurePanel path_panel(const std::string& title) {
  return {.x = {.title = "x, mm"}, .y = {.title = "y, mm"}, .title = title, .equal_scale = true};
}

/// The numbers of the paths at their ends, a little further out.
Series end_numbers(const std::vector<Series>& paths) {
  std::vector<double> all;
  for (const Series& path : paths) {
    all.insert(all.end(), path.x.begin(), path.x.end());
    all.insert(all.end(), path.y.begin(), path.y.end());
  }
  const double reach = range_of(all).size();
  Series numbers{.mark = Mark::text, .colour = kInk};
  for (std::size_t k = 0; k < paths.size(); ++k) {
    const double x = paths[k].x.back(), y = paths[k].y.back(), length = std::hypot(x, y);
    const double out = length > 0 ? 1 + kLabelBeyondEnd * reach / length : 1;
    numbers.x.push_back(out * x);
    numbers.y.push_back(out * y);
    numbers.notes.push_back(fmt::format("{}", k + 1));
  }
  return numbers;
}

/// The paths of `count` scenarios of the sweep from `first` on, named by its last axis.
FigurePanel panel_of(const PaperScenario& scenario, std::size_t first, std::size_t count,
                     const std::string& title, bool in_legend) {
  const std::vector<SweepAxis>& axes = scenario.sweep.axes();
  FigurePanel panel = path_panel(title);
  for (std::size_t k = 0; k < count; ++k) {
    const Path path = path_of(scenario.sweep.scenario(first + k), scenario.file.samples_per_cycle);
    panel.series.push_back(
        {.mark = Mark::line,
         .name =
             fmt::format("({}) {}", k + 1,
                         setting_text(axes.back().name(), scenario.sweep.value(first + k, axes.size() - 1))),
         .x = path.x_mm,
         .y = path.y_mm,
         .colour = static_cast<int>(k),
         .in_legend = in_legend,
         .small = true});
  }
  panel.series.push_back(end_numbers(panel.series));
  return panel;
}

/// One panel for each value of the sweep's first axis.
std::vector<FigurePanel> panels_of(const PaperScenario& scenario) {
  const std::vector<SweepAxis>& axes = scenario.sweep.axes();
  std::vector<FigurePanel> panels;
  for (std::size_t p = 0; p < axes[0].count(); ++p)
    panels.push_back(panel_of(
        scenario, p * axes[1].count(), axes[1].count(),
        fmt::format("{}: {}", static_cast<char>('a' + p), setting_text(axes[0].name(), axes[0].value(p))),
        p == 0));
  return panels;
}

Figure figure3() {
  const PaperScenario scenario = paper_scenario("figure3");
  FigurePanel displacement{.x = {.title = "time, s", .shown = false},
                           .y = {.title = "displacement, mm"},
                           .title = "a: displacement and friction over time",
                           .height = 1.3};
  FigurePanel friction{.x = {.title = "time, s"}, .y = {.title = "μ", .low = 0}, .height = 0.55};
  FigurePanel paths = path_panel("b: trajectory");
  paths.height = 2.1;
  std::string found;
  for (std::size_t k = 0; k < scenario.sweep.count(); ++k) {
    const model::Scenario s = scenario.sweep.scenario(k);
    const Path path = path_of(s, scenario.file.samples_per_cycle);
    const bool pulsed = s.friction.pulse_width > 0;
    const auto named = [&](Series series) {
      series.name = pulsed ? "μ ≠ const" : "μ = const";
      series.colour = static_cast<int>(k);
      return series;
    };
    const auto line = [&](const std::vector<double>& x, const std::vector<double>& y) {
      return named({.mark = Mark::line, .x = x, .y = y});
    };
    displacement.series.push_back(line(path.time_s, path.x_mm));
    displacement.series.push_back(line(path.time_s, path.y_mm));
    displacement.series.back().dashed = true;
    friction.series.push_back(named(steps_of_friction(s)));
    paths.series.push_back(line(path.x_mm, path.y_mm));
    paths.series.back().in_legend = true;
    if (!pulsed) continue;
    const Eigen::Vector2d end{path.x_mm.back(), path.y_mm.back()};
    paths.series.push_back({.mark = Mark::line,
                            .name = "covered distance",
                            .x = {0, end.x()},
                            .y = {0, end.y()},
                            .colour = kInk,
                            .in_legend = true,
                            .dashed = true});
    paths.series.push_back({.mark = Mark::text,
                            .x = {-kClearOfCircle * end.x(), (1 + kLabelBeyondEnd) * end.x()},
                            .y = {-kClearOfCircle * end.y(), (1 + kLabelBeyondEnd) * end.y()},
                            .notes = {"P₁", "P₂"},
                            .colour = kInk});
    found = fmt::format("P₁P₂ = {} mm at α = {} rad.", number(end.norm()),
                        number(model::displacement_angle(end)));
  }
  return {.id = "figure3",
          .title = "Displacement of the part",
          .caption = fmt::format("{}. Solid x, dashed y. {}", conditions_text(scenario), found),
          .alternative =
              "Displacement over time at constant and at pulsed friction, and the two trajectories: one ends "
              "on a circle, the other walks on.",
          .panels = {displacement, friction, paths},
          .height = 1.3};
}

Figure figure4() {
  Figure figure{.id = "figure4",
                .title = "Trajectories at three amplitudes",
                .caption = "",
                .alternative = "Four panels of three trajectories each.",
                .columns = 2,
                .height = 1};
  for (const char panel : {'a', 'b', 'c', 'd'}) {
    const PaperScenario scenario = paper_scenario(fmt::format("figure4{}", panel));
    const model::Friction& friction = scenario.file.scenario.friction;
    figure.panels.push_back(panel_of(scenario, 0, scenario.sweep.count(),
                                     fmt::format("{}: {}, {}", panel, setting_text("phi_rad", friction.phase),
                                                 setting_text("dtau_rad", friction.pulse_width)),
                                     panel == 'a'));
    figure.caption = conditions_text(scenario, {"phi_rad", "dtau_rad"}) + ".";
  }
  return figure;
}

Figure figure5() {
  const PaperScenario scenario = paper_scenario("figure5");
  return {
      .id = "figure5",
      .title = "Trajectories at eight phase shifts",
      .caption = conditions_text(scenario) + ".",
      .alternative = "Eight trajectories in all directions from one point, at a narrow and at a wide pulse.",
      .columns = 2,
      .panels = panels_of(scenario),
      .height = 0.62};
}

Figure figure11() {
  const PaperScenario scenario = paper_scenario("figure11");
  return {.id = "figure11",
          .title = "Trajectories, the model’s side",
          .caption = conditions_text(scenario) + ".",
          .alternative = "Trajectories of the model in four directions at three pulse widths.",
          .columns = 3,
          .panels = panels_of(scenario),
          .height = 0.42};
}

}  // namespace

std::vector<Figure> paper_trajectories() {
  return {figure3(), figure4(), figure5(), figure11()};
}

}  // namespace tribotrack::apps
