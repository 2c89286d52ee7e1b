#include "apps/report/page/figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <numbers>

#include "apps/report/data/groups.h"
#include "apps/report/data/path.h"
#include "apps/report/text/text.h"

namespace tribotrack::apps {
namespace {

using nlohmann::json;

constexpr double full_turn = 2 * std::numbers::pi;
constexpr std::size_t most_points_drawn = 3000;  // per path; enough for 20 cycles at 150 frames per cycle

/// Seven significant digits: more than any screen shows, less than half the bytes.
json drawn(double value) {
  if (!std::isfinite(value)) return nullptr;
  return std::strtod(fmt::format("{:.7g}", value).c_str(), nullptr);
}

json drawn(const std::vector<double>& values) {
  json list = json::array();
  for (const double value : values) list.push_back(drawn(value));
  return list;
}

json drawn(const std::vector<std::optional<double>>& values) {
  json list = json::array();
  for (const auto& value : values) list.push_back(value ? drawn(*value) : json(nullptr));
  return list;
}

std::string run_label(const ReportData& data, std::size_t index) {
  return fmt::format("{} {}", index + 1, data.runs[index].name);
}

/// One of the four figures of alpha or v against phi or dtau.
struct Dependence {
  const char* id;
  bool over_phi;
  bool of_alpha;
};

constexpr Dependence alpha_over_phi{"alpha-phi", true, true};
constexpr Dependence v_over_phi{"v-phi", true, false};
constexpr Dependence alpha_over_dtau{"alpha-dtau", false, true};
constexpr Dependence v_over_dtau{"v-dtau", false, false};

json curve(const ReportGroup& group, bool of_alpha) {
  if (!of_alpha) return {{"x", drawn(group.curve_x_rad)}, {"y", drawn(group.curve_v_mm_s)}};
  const BrokenCurve broken = break_at_wraps(group.curve_x_rad, group.curve_alpha_rad);
  return {{"x", drawn(broken.x)}, {"y", drawn(broken.y)}};
}

json points(const ReportData& data, const ReportGroup& group, const Dependence& figure) {
  json x = json::array(), y = json::array(), sd = json::array(), names = json::array();
  for (const std::size_t i : group.runs) {
    const ReportRun& run = data.runs[i];
    x.push_back(drawn(figure.over_phi ? phi_in_one_turn(run.phi_rad) : run.dtau_rad));
    y.push_back(drawn(figure.of_alpha ? run.alpha_rad : run.v_mm_s));
    sd.push_back(drawn(figure.of_alpha ? run.alpha_sd_rad : run.v_sd_mm_s));
    names.push_back(run_label(data, i));
  }
  return {{"x", x}, {"y", y}, {"sd", sd}, {"names", names}};
}

json dependence(const ReportData& data, const Dependence& figure) {
  json groups = json::array();
  for (const ReportGroup& group : figure.over_phi ? data.over_phi : data.over_dtau)
    groups.push_back({{"label", (figure.over_phi ? "Δτ = " : "φ = ") + angle(group.shared_rad)},
                      {"shared_rad", drawn(group.shared_rad)},
                      {"points", points(data, group, figure)},
                      {"curve", curve(group, figure.of_alpha)}});
  return {{"id", figure.id},
          {"shared_title", figure.over_phi ? "Δτ, rad" : "φ, rad"},
          {"x_title", figure.over_phi ? "phase shift φ, rad" : "pulse width Δτ, rad"},
          {"y_title", figure.of_alpha ? "displacement angle α, rad" : "mean velocity v, mm/s"},
          {"y_is_angle", figure.of_alpha},
          {"groups", groups}};
}

bool has_path(const ReportRun& run) {
  return run.failure.empty() && !run.x_mm.empty() && run.kind != "free_slide";
}

json trajectories(const ReportData& data) {
  json paths = json::array();
  for (std::size_t i = 0; i < data.runs.size(); ++i) {
    const ReportRun& run = data.runs[i];
    if (!has_path(run)) continue;
    const DrawnPath path = thinned(run.x_mm, run.y_mm, most_points_drawn);
    paths.push_back(
        {{"number", i + 1}, {"label", run_label(data, i)}, {"x", drawn(path.x)}, {"y", drawn(path.y)}});
  }
  return paths;
}

json residuals(const ReportData& data) {
  json list = json::array();
  for (std::size_t i = 0; i < data.runs.size(); ++i)
    for (const ReportResidual& r : data.runs[i].residuals)
      list.push_back({{"run", run_label(data, i)},
                      {"observable", observable_text(r.observable)},
                      {"standardised", drawn(r.standardised)},
                      {"measured", drawn(r.measured)},
                      {"modelled", drawn(r.modelled)},
                      {"sd", drawn(r.sd)}});
  return list;
}

json slides(const ReportData& data) {
  json list = json::array();
  for (const ReportSlide& slide : data.slides) {
    json residual = json::array();
    for (std::size_t i = 0; i < std::min(slide.position_mm.size(), slide.fitted_mm.size()); ++i)
      residual.push_back(drawn(1000 * (slide.position_mm[i] - slide.fitted_mm[i])));
    list.push_back({{"name", slide.name},
                    {"time_s", drawn(slide.time_s)},
                    {"position_mm", drawn(slide.position_mm)},
                    {"sigma_mm", drawn(slide.sigma_mm)},
                    {"fitted_mm", drawn(slide.fitted_mm)},
                    {"residual_um", residual}});
  }
  return list;
}

std::string plot_box(const std::string& id, const std::string& caption, const char* css = "") {
  return fmt::format(
      "<figure class=\"plot {}\"><div id=\"plot-{}\" "
      "class=\"box\"></div><figcaption>{}</figcaption></figure>\n",
      css, id, caption);
}

}  // namespace

BrokenCurve break_at_wraps(const std::vector<double>& x, const std::vector<double>& angle_rad) {
  BrokenCurve curve;
  const auto add = [&](std::optional<double> px, std::optional<double> py) {
    curve.x.push_back(px);
    curve.y.push_back(py);
  };
  for (std::size_t i = 0; i < std::min(x.size(), angle_rad.size()); ++i) {
    if (!std::isfinite(angle_rad[i])) {
      add(std::nullopt, std::nullopt);
      continue;
    }
    const bool follows = i > 0 && std::isfinite(angle_rad[i - 1]);
    if (follows && std::abs(angle_rad[i] - angle_rad[i - 1]) > std::numbers::pi) {
      // Upwards through 2 pi, or downwards through 0: where along x, on the straight line between the two
      // samples.
      const bool upwards = angle_rad[i] < angle_rad[i - 1];
      const double from = angle_rad[i - 1];
      const double to = angle_rad[i] + (upwards ? full_turn : -full_turn);
      const double edge = upwards ? full_turn : 0;
      const double at = to == from ? x[i] : x[i - 1] + (x[i] - x[i - 1]) * (edge - from) / (to - from);
      add(at, edge);
      add(std::nullopt, std::nullopt);
      add(at, full_turn - edge);
    }
    add(x[i], angle_rad[i]);
  }
  return curve;
}

std::string figures_json(const ReportData& data) {
  json figures = json::array();
  if (!data.over_phi.empty()) {
    figures.push_back(dependence(data, alpha_over_phi));
    figures.push_back(dependence(data, v_over_phi));
  }
  if (!data.over_dtau.empty()) {
    figures.push_back(dependence(data, alpha_over_dtau));
    figures.push_back(dependence(data, v_over_dtau));
  }
  const json page = {{"dependences", figures},
                     {"trajectories", trajectories(data)},
                     {"residuals", residuals(data)},
                     {"slides", slides(data)}};
  // "<" occurs only inside strings: written as an escape, nothing in them can close the script element.
  const std::string text = page.dump(-1, ' ', false, json::error_handler_t::replace);
  std::string safe;
  safe.reserve(text.size());
  for (const char c : text) {
    if (c == '<')
      safe += "\\u003c";
    else
      safe += c;
  }
  return safe;
}

std::string dependence_section(const ReportData& data) {
  const char* how =
      "Points: measured, with one standard deviation (often smaller than the point); lines: the model at "
      "the fitted parameters.";
  std::string html = "<section id=\"dependences\"><h2>Direction and velocity of the displacement</h2>\n";
  if (!data.over_phi.empty() || !data.over_dtau.empty()) html += "<div class=\"pair\">\n";
  if (!data.over_phi.empty())
    html += plot_box(
        "alpha-phi",
        fmt::format("<b>Direction against the phase of the friction pulse</b> (paper, figure 9a). "
                    "α is the angle of the displacement, counter-clockwise from the platform’s x axis; it "
                    "starts again at 0 after a full turn. {}",
                    how));
  if (!data.over_dtau.empty())
    html += plot_box(
        "alpha-dtau",
        fmt::format("<b>Direction against the width of the friction pulse</b> (paper, figure 9b). {}", how));
  if (!data.over_phi.empty())
    html += plot_box(
        "v-phi",
        fmt::format(
            "<b>Mean velocity against the phase of the friction pulse.</b> On a platform that moves in a "
            "true circle the model’s steady velocity does not depend on it. {}",
            how));
  if (!data.over_dtau.empty())
    html += plot_box(
        "v-dtau",
        fmt::format("<b>Mean velocity against the width of the friction pulse</b> (paper, figure 10). {}",
                    how));
  if (!data.over_phi.empty() || !data.over_dtau.empty()) html += "</div>\n";
  if (data.over_phi.empty())
    html +=
        "<p class=\"left-out\">No two runs differ in φ at the same Δτ: the figures of α and v against φ "
        "(paper, figure 9a) are left out.</p>\n";
  if (data.over_dtau.empty())
    html +=
        "<p class=\"left-out\">No two runs differ in Δτ at the same φ: the figures of α and v against Δτ "
        "(paper, figures 9b and 10) are left out.</p>\n";
  return html + "</section>\n";
}

std::string trajectory_plot(const ReportData& data) {
  if (std::none_of(data.runs.begin(), data.runs.end(), has_path))
    return "<p class=\"left-out\">No run with friction pulses has a tracked path: the trajectories (paper, "
           "figure 11) are left "
           "out.</p>\n";
  return plot_box("trajectories",
                  "<b>Trajectories of the part</b> (paper, figure 11), in millimetres from where each "
                  "began, y up, both axes to the same scale. The numbers are those of the table of runs; "
                  "click a name to hide its path, double-click to see it alone.",
                  "tall");
}

std::string residual_section(const ReportData& data) {
  const bool any = std::any_of(data.runs.begin(), data.runs.end(),
                               [](const ReportRun& run) { return !run.residuals.empty(); });
  if (!any)
    return data.fitted ? "<section id=\"residuals\"><h2>Residuals</h2>\n<p class=\"left-out\">The fit gave "
                         "no residuals by run: figure left out.</p></section>\n"
                       : "";
  return "<section id=\"residuals\"><h2>Residuals</h2>\n" +
         plot_box("residuals",
                  "<b>Measured minus modelled, in standard deviations.</b> If the model and the errors "
                  "are right, 19 of 20 lie inside the grey band (±2) and show no trend. Correlated "
                  "observables of a run are decorrelated first.",
                  "full") +
         "</section>\n";
}

std::string slide_row(const ReportSlideResult& s) {
  std::string blows;
  for (const std::int64_t frame : s.blow_frames)
    blows += fmt::format("{}{}", blows.empty() ? "" : ", ", frame);
  std::string html = "<tr><th>" + escape_html(s.name) + "</th>";
  html += number_cell(value_and_sd(s.mu1, s.mu1_sd));
  html += number_cell(interval_text(s.ci95.low, s.ci95.high, s.mu1_sd));
  html += number_cell(s.spin_seen
                          ? value_and_sd(s.spin_ratio, s.spin_ratio_sd)
                          : fmt::format("not seen (half: +{} %)", number(100 * s.change_by_half_spin, 2)));
  html += number_cell(fmt::format("{} / {}", number(s.chi2, 3), s.dof));
  html += number_cell(fmt::format("{}–{}", s.first_frame, s.last_frame));
  return html + cell(blows.empty() ? "–" : "frame " + blows) + "</tr>";
}

/// mu1 slide by slide, and whether they differ by chance.
std::string slide_table(const ReportData& data) {
  if (data.slide_results.empty()) return "";
  std::string html =
      "<div class=\"wide\" tabindex=\"0\"><table class=\"compact\"><thead><tr><th>slide</th><th "
      "class=\"n\">μ<sub>1</sub></th><th class=\"n\">95 % interval</th><th class=\"n\">rim speed / slide "
      "speed</th><th class=\"n\">χ² / d.o.f.</th><th class=\"n\">frames used</th><th>blow or "
      "collision</th></tr></thead><tbody>";
  for (const ReportSlideResult& slide : data.slide_results) html += slide_row(slide);
  html += "</tbody></table></div>\n";
  html +=
      "<p class=\"note\">A spinning disc is braked less; where its turning is seen, that is counted. Where "
      "not, “half” says how much larger μ<sub>1</sub> would be had the rim moved half as fast as the part "
      "slid.";
  if (!std::isnan(data.between_slides_p_value))
    html += fmt::format(
        " Between slides μ<sub>1</sub> scatters with a standard deviation of {} ({}); the interval of "
        "the mean counts it, by Student’s t of {} degrees of freedom.",
        number(data.between_slides, 2),
        data.between_slides_p_value < 0.05
            ? "more than chance explains, p = " + number(data.between_slides_p_value, 2)
            : "no more than chance explains",
        data.slide_results.size() - 1);
  return html + "</p>\n";
}

/// What the slide says by itself, its blows included.
std::string own_sentence(const ReportData& data, const std::string& name) {
  for (const ReportSlideResult& slide : data.slide_results)
    if (slide.name == name && !slide.sentence.empty()) return " By itself: " + slide.sentence;
  return "";
}

std::string slide_section(const ReportData& data) {
  std::string html;
  for (std::size_t i = 0; i < data.slides.size(); ++i)
    html += plot_box(
        fmt::format("slide-{}", i),
        fmt::format("<b>{}.</b> Distance along the slide against time, with the law of friction at its own "
                    "μ<sub>1</sub> (without spin a parabola, deceleration μ<sub>1</sub> g); below, measured "
                    "minus fitted. {}",
                    escape_html(data.slides[i].name),
                    sentence_html(data.slides[i].sentence + own_sentence(data, data.slides[i].name))),
        "full");
  if (html.empty()) return "";
  return "<section id=\"slides\"><h2>Free slides: friction on the resting platform</h2>\n" +
         slide_table(data) + html + "</section>\n";
}

}  // namespace tribotrack::apps
