#include "apps/report/page/page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "apps/page/text.h"
#include "apps/report/tables/tables.h"

namespace tribotrack::apps {
namespace {

std::string box_unless(const std::vector<Figure>& figures, const std::string& id, const std::string& shown) {
  return id == shown ? std::string() : figure_box(figures, id);
}

std::string slide_row(const fit::SlideResult& s) {
  std::string blows;
  for (const fit::Blow& blow : s.blows) blows += fmt::format("{}{}", blows.empty() ? "" : ", ", blow.frame);
  std::string html = "<tr><th>" + escape_html(s.run) + "</th>";
  html += number_cell(quoted_value(s.mu1.value, s.mu1.sd));
  html += number_cell(interval_text(s.ci95.low, s.ci95.high, s.mu1.sd));
  html += number_cell(s.slope != 0 ? fmt::format("incline of {} rad", number(std::abs(s.slope), 3))
                      : s.spin_seen
                          ? quoted_value(s.spin_ratio.value, s.spin_ratio.sd)
                          : fmt::format("not seen (half: +{} %)", number(100 * s.change_by_half_spin, 2)));
  html += number_cell(fmt::format("{} / {}", number(s.chi2, 3), s.dof));
  html += number_cell(fmt::format("{}–{}", s.first_frame, s.last_frame));
  return html + cell(blows.empty() ? "–" : "frame " + blows) + "</tr>";
}

/// mu1 slide by slide, and whether they differ by chance.
std::string slide_table(const fit::FitResult& fit) {
  if (fit.slides.empty()) return "";
  std::string rows;
  for (const fit::SlideResult& slide : fit.slides) rows += slide_row(slide);
  std::string html = table("slide-table", "compact",
                           {"slide", ">μ₁", ">95 % interval", ">edge speed / sliding speed", ">χ² / d.o.f.",
                            ">frames used", "blow or collision"},
                           rows);
  html +=
      "<p class=\"note\">A spinning disc decelerates more slowly; the fit accounts for it if the rotation is "
      "measured. If not, “half” says how much larger μ₁ would be with an edge speed of half the sliding "
      "speed.";
  if (fit.slides.size() > 1)
    html += fmt::format(
        " Between slides μ₁ scatters with a standard deviation of {} ({}); the interval of the mean includes "
        "it, by Student’s t with {} degrees of freedom.",
        number(fit.between_slides.sd, 2),
        fit.between_slides.p_value < 0.05
            ? "more than chance explains, p = " + number(fit.between_slides.p_value, 2)
            : "no more than chance explains",
        fit.slides.size() - 1);
  return html + "</p>\n";
}

}  // namespace

PageSection dependence_section(const ReportData& data, const std::vector<Figure>& figures,
                               const std::string& shown) {
  PageSection section{"dependences", "Direction, velocity and paths", ""};
  std::string boxes;
  for (const char* id : {"alpha-phi", "alpha-dtau", "v-phi", "v-dtau", "trajectories"})
    boxes += box_unless(figures, id, shown);
  if (!data.over_phi.empty() || !data.over_dtau.empty())
    section.html =
        "<p class=\"caption\">Points: measured, with one standard uncertainty. Lines: the model at the "
        "fitted parameters, with its 95 % band. Below: measured minus modelled, divided by the standard "
        "deviation that χ² uses; 19 of 20 are expected in the grey stripe.</p>\n";
  if (!boxes.empty()) section.html += "<div class=\"pair\">\n" + boxes + "</div>\n";
  if (shown.starts_with("alpha-"))
    section.html += fmt::format(
        "<p class=\"note\">The <a href=\"#figure-{}\">first figure of this page</a> belongs here, too.</p>\n",
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
        "figure 11) are left out.</p>\n";
  return section;
}

PageSection slide_section(const ReportData& data, const std::vector<Figure>& figures,
                          const std::string& shown) {
  PageSection section{"slides", "Free slides: friction on the resting platform", ""};
  std::string boxes;
  const auto slides =
      std::ranges::count_if(data.runs, [](const ReportRun& run) { return !run.fitted.slide.time.empty(); });
  for (int k = 1; k <= slides; ++k) boxes += box_unless(figures, fmt::format("slide-{}", k), shown);
  if (slides > 0) section.html = slide_table(data.fit) + boxes;
  return section;
}

namespace {

/// One way to an interval, shown where any parameter has it.
struct IntervalColumn {
  const char* heading;
  fit::Interval fit::ParameterEstimate::*interval;
};

std::vector<IntervalColumn> interval_columns(const ReportData& data) {
  std::vector<IntervalColumn> columns = {{"95 % interval", &fit::ParameterEstimate::ci95},
                                         {"by covariance", &fit::ParameterEstimate::covariance_ci95},
                                         {"by profile", &fit::ParameterEstimate::profile_ci95},
                                         {"by bootstrap", &fit::ParameterEstimate::bootstrap_ci95}};
  std::erase_if(columns, [&](const IntervalColumn& column) {
    return std::ranges::all_of(data.fit.parameters, [&](const fit::ParameterEstimate& p) {
      return std::isnan((p.*column.interval).low) || std::isnan((p.*column.interval).high);
    });
  });
  return columns;
}

bool has_column(const std::vector<IntervalColumn>& columns, fit::Interval fit::ParameterEstimate::*interval) {
  return std::ranges::count(columns, interval, &IntervalColumn::interval) > 0;
}

/// What each interval shown is, and which covariance stands behind the first.
std::string interval_note(const ReportData& data, const std::vector<IntervalColumn>& columns) {
  const bool profile = has_column(columns, &fit::ParameterEstimate::profile_ci95);
  std::string html =
      profile ? "<p class=\"note\">The 95 % interval is the one to quote: the profile’s where it differs "
                "from the covariance’s by more than a tenth, over all minima that the data allow. The "
                "covariance interval assumes that χ² is a parabola about its minimum; the profile follows χ² "
                "itself, with all other parameters fitted again at every step"
              : "<p class=\"note\">The 95 % interval comes from the fit’s covariance, assuming that χ² is a "
                "parabola about its minimum";
  if (has_column(columns, &fit::ParameterEstimate::bootstrap_ci95))
    html += fmt::format("; the bootstrap interval holds 95 % of {} refits to simulated data (seed {})",
                        data.fit.bootstrap.refits, data.fit.bootstrap.seed);
  html += ".</p>\n";
  if (!data.fit.covariance_meaning.empty())
    html += "<p class=\"note\"><b>Which covariance this is:</b> " +
            sentence_html(data.fit.covariance_meaning) + "</p>\n";
  return html;
}

}  // namespace

std::string interval_table(const ReportData& data) {
  const std::vector<IntervalColumn> columns = interval_columns(data);
  std::vector<std::string> headings = {"Parameter", ">Estimate (standard uncertainty)"};
  for (const IntervalColumn& column : columns) headings.push_back(fmt::format(">{}", column.heading));
  headings.insert(headings.end(), {"Unit", "What it is"});
  std::string html;
  for (const fit::ParameterEstimate& p : data.fit.parameters) {
    const ParameterText shown = parameter_text(p.parameter);
    html += "<tr><th>" + shown.symbol + "</th>" +
            (std::isfinite(p.sd) ? quoted_cell(p.estimate, p.sd) : number_cell("not determined"));
    for (const IntervalColumn& column : columns)
      html += "<td class=\"n ends\">" +
              (column.interval == &fit::ParameterEstimate::ci95
                   ? quoted_interval(p)
                   : interval_text((p.*column.interval).low, (p.*column.interval).high, p.sd)) +
              "</td>";
    html += cell(shown.unit.empty() ? "1" : shown.unit) + cell(shown.meaning) + "</tr>\n";
  }
  return table("parameter-table", columns.size() > 2 ? "parameters many" : "parameters", headings, html) +
         interval_note(data, columns);
}

namespace {

/// Runs that are the same but for their aim stand in one row.
struct Row {
  fit::NextExperiment run;
  std::string aims;  ///< HTML
};

bool same(const fit::NextExperiment& a, const fit::NextExperiment& b) {
  const auto alike = [](double x, double y) { return x == y || (std::isnan(x) && std::isnan(y)); };
  return alike(a.phi, b.phi) && alike(a.dtau, b.dtau) && alike(a.amplitude, b.amplitude) &&
         alike(a.angular_frequency, b.angular_frequency);
}

std::vector<Row> rows_of(const std::vector<fit::NextExperiment>& runs) {
  std::vector<Row> rows;
  for (const fit::NextExperiment& run : runs) {
    const std::string aim = run.aim ? parameter_text(*run.aim).symbol + " alone" : "all together";
    const auto known = std::ranges::find_if(rows, [&](const Row& r) { return same(r.run, run); });
    if (known == rows.end())
      rows.push_back({run, aim});
    else
      known->aims += ", " + aim;
  }
  return rows;
}

/// Rounded to its own width: a quarter of it is about one sd.
std::string interval(const fit::Interval& range) {
  return interval_text(range.low, range.high, (range.high - range.low) / 4);
}

std::string next_table(const ReportData& data) {
  std::vector<std::string> headings = {"Best for", ">φ", ">Δτ", ">A, mm", ">ω, rad/s"};
  for (const fit::ParameterEstimate& p : data.fit.parameters) {
    const ParameterText shown = parameter_text(p.parameter);
    headings.push_back(">" + shown.symbol + (shown.unit.empty() ? "" : ", " + shown.unit));
  }
  std::string html = "<tr><td>the runs so far</td><td></td><td></td><td></td><td></td>";
  for (const fit::ParameterEstimate& p : data.fit.parameters) html += number_cell(interval(p.ci95));
  html += "</tr>\n";
  for (const Row& row : rows_of(data.next_runs())) {
    html += "<tr>" + cell("<b>" + row.aims + "</b>") + number_cell(angle(row.run.phi)) +
            number_cell(angle(row.run.dtau)) + number_cell(number(1e3 * row.run.amplitude)) +
            number_cell(number(row.run.angular_frequency));
    for (const fit::ParameterEstimate& p : data.fit.parameters) {
      const auto predicted = row.run.predicted_ci95.find(p.parameter);
      html += number_cell(predicted != row.run.predicted_ci95.end() ? interval(predicted->second) : "–");
    }
    html += "</tr>\n";
  }
  html = table("next-runs", "next", headings, html) +
         "<p class=\"note\">95 % intervals now, and as predicted with one more run, measured as well as "
         "those so far. A run at another A or ω helps only if the platform can be driven so.";
  if (data.fit.identifiability.verdict == fit::Verdict::not_identifiable)
    html +=
        " The prediction assumes the values above, which these runs do not determine: the widths of the "
        "intervals are meaningful, their places are not.";
  return html + "</p>\n";
}

}  // namespace

PageSection next_section(const ReportData& data) {
  PageSection section{"next", "What to film next", ""};
  if (const std::vector<fit::NextExperiment> next = data.next_runs(); data.fitted() && !next.empty())
    section.html = "<p>" + sentence_html(next.front().sentence) + "</p>\n" + next_table(data);
  return section;
}

}  // namespace tribotrack::apps
