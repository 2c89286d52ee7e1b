#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "apps/page/text.h"
#include "apps/report/page/page.h"

namespace tribotrack::apps {
namespace {

constexpr std::size_t kMostOverTime = 180;  // over time, of each curve
constexpr std::size_t kMostOfOrbit = 200;
constexpr double kTurns = 5;  // standard deviations: less may be chance

/// Stretches of frames in which the part was not measured.
std::vector<Json> lost_spans(const Track& run) {
  std::vector<Json> spans;
  const std::size_t count = std::min(run.time_s.size(), run.x_mm.size());
  for (std::size_t i = 0, from = 0; i < count; ++i) {
    if (std::isfinite(run.x_mm[i])) {
      from = i + 1;
    } else if (i + 1 == count || std::isfinite(run.x_mm[i + 1])) {
      spans.push_back(plot::span(run.time_s[from], run.time_s[i + 1 < run.time_s.size() ? i + 1 : i]));
    }
  }
  return spans;
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

/// Does the part turn, beyond what its sd explains?
bool part_turns(const ReportRun& run) {
  return run.failure.empty() && range_of(run.track.theta_rad).size() > kTurns * run.sigma_theta_rad;
}

std::vector<Figure> over_time(const ReportData& data, std::size_t index) {
  const ReportRun& shown = data.runs[index];
  const Track& run = shown.track;
  if (run.time_s.empty() || run.x_mm.empty()) return {};
  Figure figure{.id = fmt::format("run-{}", index + 1), .title = "Over time: " + run_label(data, index)};
  const std::vector<Json> lost = lost_spans(run);
  const auto panel = [&](const Json& y, std::vector<Json> traces, double height = 1) {
    figure.panels.push_back({.x = plot::hidden(plot::axis("time, s")),
                             .y = y,
                             .traces = std::move(traces),
                             .shapes = lost,
                             .height = height});
  };
  const auto drawn = [&](const auto& mark, const char* name, const Values& y, int colour,
                         bool legend = true) {
    const std::vector<std::size_t> places = envelope(y, kMostOverTime);
    return mark(name, picked(run.time_s, places), picked(y, places),
                plot::Look{.colour = colour, .legend = legend, .small = true});
  };
  const auto dots = [](const char* name, const Values& x, const Values& y, const plot::Look& look) {
    return plot::points(name, x, y, look);
  };
  const auto any = [](const Values& v) {
    return std::ranges::any_of(v, [](double x) { return std::isfinite(x); });
  };
  panel(plot::axis("x, y, mm"), {drawn(plot::line, "x", run.x_mm, 0), drawn(plot::line, "y", run.y_mm, 1)},
        1.6);
  if (!shown.model_x_mm.empty())
    panel(plot::with_zero_line(plot::axis("residual, µm")),
          {drawn(dots, "x", left_um(run.x_mm, shown.model_x_mm), 0, false),
           drawn(dots, "y", left_um(run.y_mm, shown.model_y_mm), 1, false)});
  if (any(run.sigma_px))
    panel(plot::axis("σ, px", 0, 1.2 * range_of(run.sigma_px).high), {drawn(dots, "σ", run.sigma_px, 2)},
          0.8);
  if (any(run.ncc)) panel(plot::axis("NCC score"), {drawn(dots, "NCC", run.ncc, 3)}, 0.8);
  if (part_turns(shown)) panel(plot::axis("rotation θ, rad"), {drawn(plot::line, "θ", run.theta_rad, 4)});
  figure.panels.back().x = plot::axis("time, s");
  figure.shared_x = true;
  figure.height = 0.1 + 0.14 * static_cast<double>(figure.panels.size());
  figure.alternative =
      fmt::format("Position, residual, sd and score over time of run {}.", run_label(data, index));
  return {figure};
}

Json frames(const Values& x, const Values& y, bool legend) {
  const DrawnPath drawn = thinned(x, y, kMostOfOrbit);
  return plot::points("frames", drawn.x, drawn.y, {.legend = legend, .small = true});
}

std::vector<Figure> platform(const ReportData& data, std::size_t index) {
  const ReportRun& run = data.runs[index];
  if (run.platform.orbit.empty()) return {};
  const auto in_mm = [](const std::vector<Eigen::Vector2d>& points, Eigen::Index axis) {
    Values mm;
    for (const Eigen::Vector2d& point : points) mm.push_back(1e3 * point[axis]);
    return mm;
  };
  Values left_mrad;
  for (const double rad : run.platform.phase_left) left_mrad.push_back(1e3 * rad);
  Figure figure{.id = fmt::format("platform-{}", index + 1), .title = "Platform: " + run_label(data, index)};
  figure.panels = {{.x = plot::axis("ξ, mm"),
                    .y = plot::axis("η, mm"),
                    .traces = {frames(in_mm(run.platform.orbit, 0), in_mm(run.platform.orbit, 1), true),
                               plot::line("fitted", in_mm(run.platform.model, 0),
                                          in_mm(run.platform.model, 1), {.colour = 1, .legend = true})},
                    .equal_scale = true},
                   {.x = plot::axis("time, s"),
                    .y = plot::with_zero_line(plot::axis("phase residual, mrad")),
                    .traces = {frames(run.track.table.time, left_mrad, false)}}};
  figure.columns = 2;
  figure.height = 0.42;
  figure.alternative =
      fmt::format("Orbit and phase residual of the platform in run {}.", run_label(data, index));
  return {figure};
}

}  // namespace

std::vector<Figure> run_figures(const ReportData& data, std::size_t index) {
  std::vector<Figure> figures = over_time(data, index);
  for (const Figure& more : platform(data, index)) figures.push_back(more);
  return figures;
}

namespace {

constexpr std::size_t kMostOfSlide = 600;

/// What the slide says by itself, its blows included.
std::string own_sentence(const ReportData& data, const std::string& name) {
  for (const fit::SlideResult& slide : data.fit.slides)
    if (slide.run == name && !slide.sentence.empty()) return " By itself: " + slide.sentence;
  return "";
}

}  // namespace

std::vector<Figure> slide_figures(const ReportData& data) {
  std::vector<Figure> figures;
  for (const ReportRun& run : data.runs) {
    const auto& slide = run.fitted.slide;
    if (slide.time.empty()) continue;
    Values position_mm, fitted_mm, left_um;
    for (std::size_t k = 0; k < std::min(slide.measured.size(), slide.modelled.size()); ++k) {
      position_mm.push_back(1e3 * slide.measured[k]);
      fitted_mm.push_back(1e3 * slide.modelled[k]);
      left_um.push_back(1000 * (position_mm[k] - fitted_mm[k]));
    }
    const std::vector<std::size_t> places = envelope(left_um, kMostOfSlide);
    const Values time = picked(slide.time, places);
    const Panel main{.x = plot::hidden(plot::axis("time, s")),
                     .y = plot::axis("distance, mm"),
                     .traces = {plot::points("measured", time, picked(position_mm, places),
                                             {.legend = true, .small = true}),
                                plot::line("law of friction", time, picked(fitted_mm, places),
                                           {.colour = 1, .legend = true})},
                     .height = 2.4};
    const Panel below{.x = plot::axis("time, s"),
                      .y = plot::with_zero_line(plot::axis("residual, µm")),
                      .traces = {plot::points("", time, picked(left_um, places), {.small = true})}};
    Figure figure{.id = fmt::format("slide-{}", figures.size() + 1), .title = "Free slide " + run.name};
    figure.caption =
        "Distance along the slide against time, with the law of friction at its own μ₁ (without spin a "
        "parabola, deceleration μ₁ g); below, measured minus fitted. " +
        sentence_html(run.fitted.slide.sentence + own_sentence(data, run.name));
    figure.alternative =
        fmt::format("Free slide {}: distance against time and the residual below.", run.name);
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
  return run.failure.empty() && !run.track.x_mm.empty() && !run.free_slide;
}

}  // namespace

std::vector<Figure> trajectory_figures(const ReportData& data) {
  std::vector<std::size_t> drawn;
  for (std::size_t i = 0; i < data.runs.size(); ++i)
    if (has_path(data.runs[i])) drawn.push_back(i);
  if (drawn.empty()) return {};
  Values across, along;
  for (const std::size_t i : drawn) {
    across.insert(across.end(), data.runs[i].track.x_mm.begin(), data.runs[i].track.x_mm.end());
    along.insert(along.end(), data.runs[i].track.y_mm.begin(), data.runs[i].track.y_mm.end());
  }
  const Range reach = hull(range_of(across), range_of(along));
  Panel panel{.x = plot::axis("x, mm"), .y = plot::axis("y, mm"), .equal_scale = true};
  bool modelled = false, marked = false;
  std::vector<Json> paths;
  Notes numbers;
  const std::size_t most = std::min(kMostOfPath, kMostOfAll / drawn.size());
  for (std::size_t k = 0; k < drawn.size(); ++k) {
    const ReportRun& run = data.runs[drawn[k]];
    const int colour = static_cast<int>(k);
    const DrawnPath path = thinned(run.track.x_mm, run.track.y_mm, most);
    paths.push_back(plot::line(run_label(data, drawn[k]), path.x, path.y, {.colour = colour, .small = true}));
    numbers.push_back(std::to_string(drawn[k] + 1));
    panel.traces.push_back(paths.back());
    if (!run.model_x_mm.empty()) {
      const DrawnPath model = thinned(run.model_x_mm, run.model_y_mm, most);
      panel.traces.push_back(
          plot::line("model", model.x, model.y,
                     {.colour = plot::kInk, .legend = !modelled, .dashed = true, .small = true}));
      modelled = true;
    }
    if (!run.cycle_x_mm.empty()) {
      Notes notes;
      for (std::size_t c = 0; c < run.cycle_x_mm.size(); ++c)
        notes.push_back(fmt::format("{}, {} cycle{}", run_label(data, drawn[k]), c, c == 1 ? "" : "s"));
      panel.traces.push_back(plot::points("whole cycles", run.cycle_x_mm, run.cycle_y_mm,
                                          {.colour = colour, .legend = !marked, .small = true}, notes));
      marked = true;
    }
  }
  if (drawn.size() <= 60) panel.traces.push_back(plot::end_numbers(paths, numbers));
  Figure figure{.id = "trajectories", .title = "Trajectories of the part (paper, figure 11)"};
  figure.caption =
      "In millimetres from where each began, y up, both axes to the same scale. The numbers are those of the "
      "table of runs.";
  if (marked) figure.caption += " Dots: the end of each whole cycle of the platform.";
  if (modelled)
    figure.caption +=
        " Dashed: the model at the fitted parameters, started where the part was, at the platform’s phase "
        "there.";
  figure.alternative =
      fmt::format("Paths of {} runs over the platform, {} mm across.", drawn.size(), number(reach.size(), 2));
  figure.panels = {panel};
  const double aspect = range_of(along).size() / range_of(across).size();
  figure.width = std::clamp(0.72 / aspect, 0.5, 1.0);
  figure.height = std::clamp(aspect + 0.05, 0.35, 1.15);
  return {figure};
}

}  // namespace tribotrack::apps
