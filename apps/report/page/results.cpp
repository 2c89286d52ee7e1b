#include "apps/report/page/results.h"

#include <fmt/format.h>

#include <algorithm>

#include "apps/page/text.h"
#include "apps/report/page/pictures.h"

namespace tribotrack::apps {
namespace {

std::string box_unless(const std::vector<Figure>& figures, const std::string& id, const std::string& shown) {
  return id == shown ? std::string() : figure_box(figures, id);
}

std::string slide_row(const ReportSlideResult& s) {
  std::string blows;
  for (const std::int64_t frame : s.blow_frames)
    blows += fmt::format("{}{}", blows.empty() ? "" : ", ", frame);
  std::string html = "<tr><th>" + escape_html(s.name) + "</th>";
  html += number_cell(quoted_value(s.mu1, s.mu1_sd));
  html += number_cell(interval_text(s.ci95.low, s.ci95.high, s.mu1_sd));
  html += number_cell(s.slope_rad != 0 ? fmt::format("incline of {} rad", number(std::abs(s.slope_rad), 3))
                      : s.spin_seen
                          ? quoted_value(s.spin_ratio, s.spin_ratio_sd)
                          : fmt::format("not seen (half: +{} %)", number(100 * s.change_by_half_spin, 2)));
  html += number_cell(fmt::format("{} / {}", number(s.chi2, 3), s.dof));
  html += number_cell(fmt::format("{}–{}", s.first_frame, s.last_frame));
  return html + cell(blows.empty() ? "–" : "frame " + blows) + "</tr>";
}

/// mu1 slide by slide, and whether they differ by chance.
std::string slide_table(const ReportData& data) {
  if (data.slide_results.empty()) return "";
  std::string html =
      "<div class=\"wide\"><table id=\"slide-table\" class=\"compact\"><thead><tr><th>slide</th><th "
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

}  // namespace

PageSection dependence_section(const ReportData& data, const std::vector<Figure>& figures,
                               const std::string& shown) {
  PageSection section{"dependences", "Direction, velocity and paths", ""};
  std::string boxes;
  for (const char* id : {"alpha-phi", "alpha-dtau", "v-phi", "v-dtau", "trajectories"})
    boxes += box_unless(figures, id, shown);
  if (!boxes.empty()) section.html = "<div class=\"pair\">\n" + boxes + "</div>\n";
  if (shown.starts_with("alpha-"))
    section.html += fmt::format(
        "<p class=\"note\">The <a href=\"#figure-{}\">first figure of this page</a> belongs here, "
        "too.</p>\n",
        shown);
  if (data.over_phi.empty())
    section.html +=
        "<p class=\"left-out\">No two runs differ in φ at the same Δτ: the figures of α and v against φ "
        "(paper, figure 9a) are left out.</p>\n";
  if (data.over_dtau.empty())
    section.html +=
        "<p class=\"left-out\">No two runs differ in Δτ at the same φ: the figures of α and v against Δτ "
        "(paper, figures 9b and 10) are left out.</p>\n";
  if (std::ranges::find(figures, std::string("trajectories"), &Figure::id) == figures.end())
    section.html +=
        "<p class=\"left-out\">No run with friction pulses has a tracked path: the trajectories (paper, "
        "figure 11) are "
        "left out.</p>\n";
  return section;
}

PageSection picture_section(const ReportData& data) {
  return {"pictures", "The paths over the first frames", pictures_of_runs(data), true};
}

PageSection slide_section(const ReportData& data, const std::vector<Figure>& figures,
                          const std::string& shown) {
  PageSection section{"slides", "Free slides: friction on the resting platform", ""};
  std::string boxes;
  for (std::size_t i = 0; i < data.slides.size(); ++i)
    boxes += box_unless(figures, fmt::format("slide-{}", i + 1), shown);
  if (data.slides.empty()) return section;
  section.html = slide_table(data) + boxes;
  return section;
}

}  // namespace tribotrack::apps
