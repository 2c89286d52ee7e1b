// Figures 6, 7, 9 and 10.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "apps/figures/axes.h"
#include "apps/paper/figures.h"
#include "apps/paper/scenarios.h"
#include "model/batch.h"

namespace tribotrack::apps {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kTurn = 2 * kPi;

struct Solved {
  PaperScenario scenario;
  model::BatchOutcome outcome;
};

Solved solved(const char* name, int threads) {
  Solved solved{paper_scenario(name), {}};
  model::BatchOptions options;
  options.steady = true;
  options.threads = threads;
  const Sweep& sweep = solved.scenario.sweep;
  solved.outcome = model::solve_batch(
      sweep.count(), [&sweep](std::size_t index) { return sweep.scenario(index); }, options);
  if (!solved.outcome.reasons.empty()) {
    for (const auto& [index, reason] : solved.outcome.reasons)
      if (solved.outcome.ends[index].status != model::BatchStatus::done) throw std::runtime_error(reason);
  }
  return solved;
}

/// A point of a curve of angles in [0, 2 pi), which breaks where it starts again at the other end.
void add_angle(Series& curve, double x, double alpha) {
  if (!curve.y.empty() && std::abs(alpha - curve.y.back()) > kPi) {
    const bool upwards = alpha < curve.y.back();
    const double to = alpha + (upwards ? kTurn : -kTurn), edge = upwards ? kTurn : 0;
    const double share = (edge - curve.y.back()) / (to - curve.y.back());
    const double at = curve.x.back() + share * (x - curve.x.back());
    curve.x.insert(curve.x.end(), {at, at, at});
    curve.y.insert(curve.y.end(), {edge, kNone, kTurn - edge});
  }
  curve.x.push_back(x);
  curve.y.push_back(alpha);
}

template <class Solution>
void add_point(Series& curve, double x, const Solution& solution, bool of_alpha) {
  const bool known = solution.status == model::BatchStatus::done;
  if (!of_alpha) {
    curve.x.push_back(x);
    curve.y.push_back(known ? 1e3 * solution.v : kNone);
  } else if (known && std::isfinite(solution.alpha)) {
    add_angle(curve, x, solution.alpha);
  }
}

/// The names of a sweep's curves: by its first axis, or by mu1 where there is one axis only.
std::vector<std::string> curve_names(const PaperScenario& scenario) {
  const SweepAxis& first = scenario.sweep.axes().front();
  if (scenario.sweep.axes().size() == 1)
    return {setting_text("mu1", scenario.file.scenario.friction.nominal)};
  std::vector<std::string> names;
  for (std::size_t k = 0; k < first.count(); ++k) names.push_back(setting_text(first.name(), first.value(k)));
  return names;
}

/// One panel: alpha or v along the sweep's last axis. `colours`: the figure's names of curves.
FigurePanel panel_of(const Solved& solved, bool of_alpha, const std::string& title,
                     const std::vector<std::string>& colours) {
  const Sweep& sweep = solved.scenario.sweep;
  const std::size_t last = sweep.axes().size() - 1, points = sweep.axes()[last].count();
  FigurePanel panel{
      .x = axis_of(sweep.axes()[last]), .y = {.title = "velocity v, mm/s", .low = 0}, .title = title};
  constexpr double kSpare = 0.12;  // rad, above and below the full circle
  if (of_alpha) panel.y = angle_axis("angle α, rad", -kSpare, kTurn + kSpare);
  std::size_t index = 0;
  for (const std::string& name : curve_names(solved.scenario)) {
    const auto colour = static_cast<int>(std::ranges::find(colours, name) - colours.begin());
    Series from_rest{.mark = Mark::line, .name = name, .colour = colour};
    Series steady{.mark = Mark::line, .name = name, .colour = colour, .dashed = true, .small = true};
    for (const std::size_t end = index + points; index < end; ++index) {
      add_point(from_rest, sweep.value(index, last), solved.outcome.ends[index], of_alpha);
      add_point(steady, sweep.value(index, last), solved.outcome.steady[index], of_alpha);
    }
    panel.series.push_back(from_rest);
    panel.series.push_back(steady);
  }
  return panel;
}

/// Where v is greatest along each curve from rest, and where the paper has it.
void mark_greatest(FigurePanel& panel) {
  constexpr double kGreatestInPaper = 1.5 * kPi;  // "increases up to 3 pi/2"
  Series greatest{.mark = Mark::points, .name = "greatest v", .colour = kInk, .in_legend = true};
  for (const Series& curve : panel.series) {
    if (curve.dashed) continue;
    const auto at = static_cast<std::size_t>(std::ranges::max_element(curve.y) - curve.y.begin());
    greatest.x.push_back(curve.x[at]);
    greatest.y.push_back(curve.y[at]);
  }
  const double top = *std::ranges::max_element(greatest.y);
  panel.series.push_back({.mark = Mark::line,
                          .name = "3π/2, the paper’s",
                          .x = {kGreatestInPaper, kGreatestInPaper},
                          .y = {0, top},
                          .colour = kGrey,
                          .in_legend = true});
  panel.series.push_back(greatest);
}

/// A figure's panels are called "a: ..." and so on where there are several.
struct PanelSource {
  const Solved& solved;
  bool of_alpha;
};

Figure figure_of(const char* id, const char* title, const std::vector<PanelSource>& sources) {
  Figure figure{.id = id, .title = title, .caption = ""};
  const auto& most = *std::ranges::max_element(
      sources, {}, [](const PanelSource& source) { return curve_names(source.solved.scenario).size(); });
  const std::vector<std::string> names =
      curve_names(most.solved.scenario);  // the other panels show some of them
  for (std::size_t k = 0; k < sources.size(); ++k) {
    const std::string letter = sources.size() == 1 ? "" : std::string(1, static_cast<char>('a' + k));
    figure.panels.push_back(panel_of(sources[k].solved, sources[k].of_alpha, letter, names));
    if (&sources[k] == &most)
      for (Series& series : figure.panels.back().series) series.in_legend = !series.dashed;
    figure.caption += fmt::format("{}{}. ", letter.empty() ? "" : letter + ": ",
                                  conditions_text(sources[k].solved.scenario));
  }
  figure.columns = sources.size() > 1 ? 2 : 1;
  figure.height = sources.size() > 2 ? 0.9 : sources.size() == 2 ? 0.5 : 0.62;
  figure.caption += "Solid: from rest, as the paper counts; dashed: the steady motion.";
  figure.alternative = fmt::format("{}: {} panel{} of curves from rest and of the steady motion.", title,
                                   sources.size(), sources.size() == 1 ? "" : "s");
  return figure;
}

}  // namespace

std::vector<Figure> paper_dependences(int threads) {
  const Solved width = solved("figure6a", threads), ratio = solved("figure6b", threads),
               amplitude = solved("figure6c", threads), frequency = solved("figure6d", threads);
  Figure velocity = figure_of("figure6", "Mean displacement velocity",
                              {{width, false}, {ratio, false}, {amplitude, false}, {frequency, false}});
  mark_greatest(velocity.panels.front());
  const Solved phase = solved("figure7a", threads), alpha_width = solved("figure7b", threads),
               measured_phase = solved("figure9a", threads), measured_width = solved("figure9b", threads),
               measured_v = solved("figure10", threads);
  // Figures 7c and 7d have the conditions of 6c and 6d.
  return {velocity,
          figure_of("figure7", "Displacement angle",
                    {{phase, true}, {alpha_width, true}, {amplitude, true}, {frequency, true}}),
          figure_of("figure9", "Displacement angle, the model’s side",
                    {{measured_phase, true}, {measured_width, true}}),
          figure_of("figure10", "Mean displacement velocity, the model’s side", {{measured_v, false}})};
}

}  // namespace tribotrack::apps
