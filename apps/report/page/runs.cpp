#include "apps/report/page/page.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "apps/page/text.h"
#include "apps/report/data/data.h"

namespace tribotrack::apps {
namespace {

/// The recording's file, unless the run is simply named after it.
std::string video_line(const ReportRun& run) {
  const bool named_after = run.video == run.name || run.video.rfind(run.name + ".", 0) == 0;
  if (run.video.empty() || named_after) return "";
  return fmt::format("<br><span class=\"small\">{}</span>", escape_html(run.video));
}

std::string angle_cell(const ReportRun& run, double rad, const char* of_slide) {
  if (run.free_slide || !std::isfinite(rad)) return number_cell(run.free_slide ? of_slide : "–");
  return fmt::format("<td class=\"n\" data-v=\"{}\">{}</td>", rad, angle(rad));
}

std::string run_row(const ReportRun& run, std::size_t index) {
  std::string html = fmt::format("<tr{}>", run.failure.empty() ? "" : " class=\"failed\"");
  html += number_cell(std::to_string(index + 1));
  html += fmt::format("<td><b>{}</b>{}</td>", escape_html(run.name), video_line(run));
  if (!run.failure.empty())
    return html + "<td colspan=\"10\">failed: " + escape_html(run.failure) + "</td></tr>\n";
  html += angle_cell(run, run.phi_rad, "free slide");
  html += angle_cell(run, run.dtau_rad, "–");
  for (const char* observable : {"alpha_rad", "v_mm_s"}) {
    const fit::Estimate measured = run.value(observable);
    html += quoted_cell(measured.value, measured.sd);
    html += number_cell(rounded(run.modelled(observable), measured.sd));
  }
  html += number_cell(run.cycles > 0 ? std::to_string(run.cycles) : "–");
  const Track& track = run.track;
  html += number_cell(track.frames > 0 ? fmt::format("{} / {} / {} / {}", run.frames_ok(), track.lost,
                                                     track.edge, track.repeats)
                                       : "no video");
  html += number_cell(rounded(run.sigma_px, run.sigma_px));
  std::string time_base = track.frame_rate_hz ? number(*track.frame_rate_hz, 6) + " Hz" : "";
  if (!track.time_base.empty()) time_base += (time_base.empty() ? "" : ", ") + escape_html(track.time_base);
  html += cell(time_base.empty() ? "–" : time_base);
  return html + "</tr>\n";
}

std::string error_bound(const vision::PlanStage& stage) {
  if (stage.on) return "";
  if (!stage.error_bound_px) return "not known";
  return *stage.error_bound_px == 0 ? "none" : number(*stage.error_bound_px, 2) + " px";
}

std::string stage_table(const std::vector<vision::PlanStage>& stages) {
  std::string html =
      "<table class=\"compact plan\"><thead><tr><th>Stage</th><th>State</th><th>Reason</th><th>Error this "
      "can add</th></tr></thead><tbody>";
  for (const vision::PlanStage& stage : stages)
    html += "<tr>" + cell(escape_html(stage.name)) + cell(stage.on ? "done" : "<b>left out</b>") +
            cell(sentence_html(stage.reason)) + cell(error_bound(stage)) + "</tr>";
  return html + "</tbody></table>\n";
}

using Group = std::vector<std::size_t>;

/// Runs in which the same stages were left out; the figures in the reasons are those of the first.
std::vector<Group> plan_groups(const std::vector<ReportRun>& runs) {
  std::vector<Group> groups;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    if (runs[i].track.plan.empty()) continue;
    const auto same = std::ranges::find_if(groups, [&](const Group& group) {
      return std::ranges::equal(
          runs[group.front()].track.plan, runs[i].track.plan,
          [](const auto& x, const auto& y) { return x.name == y.name && x.on == y.on; });
    });
    if (same == groups.end())
      groups.push_back({i});
    else
      same->push_back(i);
  }
  return groups;
}

/// "1 name", or "runs 1, 3, 4" for several.
std::string group_name(const Group& group, const std::vector<ReportRun>& runs) {
  if (group.size() == 1)
    return fmt::format("{} {}", group.front() + 1, escape_html(runs[group.front()].name));
  std::string text;
  for (const std::size_t i : group) text += fmt::format("{}{}", text.empty() ? "runs " : ", ", i + 1);
  return text;
}

}  // namespace

PageSection run_section(const ReportData& data) {
  PageSection section{"runs", "Runs", "", true};
  if (data.runs.empty()) return section;
  std::string& html = section.html;
  std::string rows;
  for (std::size_t i = 0; i < data.runs.size(); ++i) rows += run_row(data.runs[i], i);
  html = table("run-table", "runs sortable",
               {">#", "Run", ">φ", ">Δτ", ">α, rad", ">model", ">v, mm/s", ">model", ">cycles",
                ">frames found / lost / edge / repeated", ">σ, px", "Frame rate from"},
               rows);
  html +=
      "<p class=\"note\">In parentheses one standard uncertainty, in the last digits. α: direction of the "
      "displacement, counter-clockwise from the platform’s x axis; v: mean velocity over the whole cycles. "
      "Frames: part found, lost, at the edge of the picture, or stored twice. σ: median standard deviation "
      "of a tracked position, per axis. The table is sorted by a click on a heading; <code>runs.csv</code> "
      "holds it with all digits.</p>\n";
  std::vector<std::string> notes;
  for (const ReportRun& run : data.runs)
    for (const std::string& note : run.notes) notes.push_back(run.name + ": " + note);
  if (!notes.empty()) html += "<h3>Remarks</h3>\n" + html_list(pooled_by_cause(notes, data.runs));
  return section;
}

namespace {

std::string platform_numbers(const ReportRun& run) {
  std::vector<std::string> parts;
  const auto add = [&](const char* symbol, const char* key, const char* unit) {
    const fit::Estimate seen = run.value(key);
    if (!std::isnan(seen.value))
      parts.push_back(fmt::format("{} = {} {}", symbol, quoted_value(seen.value, seen.sd), unit));
  };
  add("A", "amplitude_mm", "mm");
  add("Ay", "amplitude_y_mm", "mm");
  add("ω", "angular_frequency_rad_s", "rad/s");
  add("ε", "phase_shift_rad", "rad");
  add("dω/dt", "angular_frequency_drift_rad_s2", "rad/s²");
  for (const fit::Harmonic& h : run.harmonics)
    parts.push_back(fmt::format("{}ω: {} mm along x, {} mm along y", h.order,
                                quoted_value(1e3 * h.amplitude.value, 1e3 * h.amplitude.sd),
                                quoted_value(1e3 * h.amplitude_y.value, 1e3 * h.amplitude_y.sd)));
  add("φ", "phi_rad", "rad");
  add("Δτ", "dtau_rad", "rad");
  if (!run.gate_source.empty()) parts.push_back("gate from the " + escape_html(run.gate_source));
  return parts.empty() ? "over time" : fmt::format("{}", fmt::join(parts, "; "));
}

}  // namespace

PageSection audit_section(const ReportData& data) {
  PageSection section{"audit", "Are the stated uncertainties right?", "", true};
  std::string rows;
  for (std::size_t i = 0; i < data.runs.size(); ++i) {
    const vision::Audit& audit = data.runs[i].track.audit;
    const std::array ratios = {audit.halves_x, audit.halves_y, audit.high_frequency};
    if (std::ranges::none_of(ratios, [](const auto& ratio) { return ratio.has_value(); })) continue;
    rows +=
        "<tr>" + number_cell(std::to_string(i + 1)) + cell("<b>" + escape_html(data.runs[i].name) + "</b>");
    for (const std::optional<double>& ratio : ratios)
      rows += number_cell(ratio ? fmt::format("{:.2f}", *ratio) : "–");
    rows += number_cell(fmt::format("{:.2f}", std::sqrt(audit.white_factor))) +
            number_cell(fmt::format("{:.4f}", audit.slow_sd)) + "</tr>\n";
  }
  if (rows.empty()) return section;
  section.html = table("audit-table", "compact",
                       {">#", "Run", ">left / right", ">top / bottom", ">frame to frame", ">σ widened by",
                        ">correlated error added, px"},
                       rows) +
                 "<p class=\"note\">Ratios of the observed scatter to what the tracking’s own standard "
                 "deviations predict; 1: as predicted. The first two are split-half tests: positions from "
                 "complementary halves of the part’s pixels. Frame to frame: scatter of consecutive "
                 "positions where the motion is slow. The σ of all tables are the widened ones.</p>\n";
  return section;
}

PageSection plan_section(const ReportData& data) {
  PageSection section{"plan", "Stages left out, and why", "", true};
  for (const Group& group : plan_groups(data.runs)) {
    const auto& plan = data.runs[group.front()].track.plan;
    section.html += fmt::format(
        "<details class=\"print\"><summary>{}: {} of {} stages left out</summary>\n{}</details>\n",
        group_name(group, data.runs), std::ranges::count(plan, false, &vision::PlanStage::on), plan.size(),
        stage_table(plan));
  }
  if (section.html.empty()) return section;
  section.html =
      "<p class=\"note\">Before it tracks a recording, the program decides which stages its scene does not "
      "need.</p>\n" +
      section.html;
  return section;
}

PageSection detail_section(const ReportData& data, const std::vector<std::vector<Figure>>& of_runs) {
  PageSection section{"details", "Run by run", "", true};
  for (std::size_t i = 0; i < of_runs.size(); ++i) {
    if (of_runs[i].empty()) continue;
    section.html +=
        fmt::format("<details class=\"screen-only\" id=\"details-{0}\"><summary>{0} {1}: {2}</summary>\n",
                    i + 1, escape_html(data.runs[i].name), platform_numbers(data.runs[i]));
    for (const Figure& figure : of_runs[i]) section.html += figure_box(figure);
    section.html += "</details>\n";
  }
  if (section.html.empty()) return section;
  std::string text =
      "<p class=\"note screen-only\">Each run over time: position relative to the first frame; residual: "
      "measured minus modelled at the fitted parameters, about its mean; σ: standard deviation of a position "
      "per axis; NCC: score of the template, 1 for a perfect match; shaded: part not found. Of long runs the "
      "lowest and the highest point of every stretch are drawn. The platform: its orbit with the motion "
      "fitted to all frames; the phase residual of a constant frequency, in which a bend is a drift of the "
      "drive.</p>\n";
  if (!data.phase_reference.empty()) text += "<p>" + sentence_html(data.phase_reference) + "</p>\n";
  section.html = text + section.html;
  return section;
}

namespace {

constexpr std::size_t most_points_drawn = 500;  // over a picture a few hundred pixels wide

std::string phi_and_dtau(const ReportRun& run) {
  if (run.free_slide) return "free slide";
  std::string text;
  if (std::isfinite(run.phi_rad)) text += "φ = " + angle(run.phi_rad);
  if (std::isfinite(run.dtau_rad)) text += (text.empty() ? "Δτ = " : ", Δτ = ") + angle(run.dtau_rad);
  return text;
}

/// An SVG path through the measured points; a gap where the part was not measured.
std::string path_commands(const ReportRun& run) {
  const DrawnPath path = thinned(run.track.x_px, run.track.y_px, most_points_drawn);
  std::string commands;
  bool pen_down = false;
  for (std::size_t i = 0; i < path.x.size(); ++i) {
    const bool measured = !std::isnan(path.x[i]);
    // Pixel centres are at whole numbers, the picture's corner at (-0.5, -0.5).
    if (measured)
      commands += fmt::format("{}{:.1f} {:.1f}", pen_down ? "L" : "M", path.x[i] + 0.5, path.y[i] + 0.5);
    pen_down = measured;
  }
  return commands;
}

struct Ends {
  std::size_t first = 0, last = 0;
  bool any = false;
};

Ends measured_ends(const Track& track) {
  Ends ends;
  for (std::size_t i = 0; i < std::min(track.x_px.size(), track.y_px.size()); ++i) {
    if (!std::isfinite(track.x_px[i]) || !std::isfinite(track.y_px[i])) continue;
    if (!ends.any) ends.first = i;
    ends.last = i;
    ends.any = true;
  }
  return ends;
}

std::string mime_type(const std::vector<unsigned char>& bytes) {
  return bytes.size() > 1 && bytes[0] == 0xff && bytes[1] == 0xd8 ? "image/jpeg" : "image/png";
}

/// `place`: an id of its own on the page.
std::string picture(const ReportRun& run, std::size_t index, const std::string& place) {
  const Track& track = run.track;
  const Ends ends = measured_ends(track);
  const double radius = 0.012 * std::max(track.width_px, track.height_px);
  std::string html = fmt::format(
      "<figure class=\"frame\" id=\"{5}\"><svg viewBox=\"0 0 {0} {1}\" role=\"img\" aria-label=\"path of the "
      "part in run {2}\"><image href=\"data:{3};base64,{4}\" width=\"{0}\" height=\"{1}\" "
      "preserveAspectRatio=\"none\"/>",
      track.width_px, track.height_px, escape_html(run.name), mime_type(run.first_frame),
      base64(run.first_frame), place);
  if (ends.any) {
    const std::string path = path_commands(run);
    html += fmt::format("<path class=\"halo\" d=\"{0}\"/><path class=\"path\" d=\"{0}\"/>", path);
    html += fmt::format("<circle class=\"start\" cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{:.1f}\"/>",
                        track.x_px[ends.first] + 0.5, track.y_px[ends.first] + 0.5, radius);
    html += fmt::format("<rect class=\"end\" x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\"/>",
                        track.x_px[ends.last] + 0.5 - radius, track.y_px[ends.last] + 0.5 - radius,
                        2 * radius, 2 * radius);
  }
  html += fmt::format("</svg><figcaption><b>{}</b> {}<br>{}</figcaption></figure>\n", index + 1,
                      escape_html(run.name), phi_and_dtau(run));
  return html;
}

bool has_picture(const ReportRun& run) {
  return !run.first_frame.empty() && run.track.width_px > 0 && run.track.height_px > 0;
}

}  // namespace

PageSection picture_section(const ReportData& data) {
  PageSection section{"pictures", "The paths over the first frames", "", true};
  std::string pictures;
  for (std::size_t i = 0; i < data.runs.size(); ++i)
    if (has_picture(data.runs[i])) pictures += picture(data.runs[i], i, fmt::format("frame-{}", i + 1));
  section.html =
      pictures.empty()
          ? "<p class=\"left-out\">No run has a recording at hand: pictures of the paths left out.</p>\n"
          : "<div class=\"frames\">\n" + pictures +
                "</div>\n<p class=\"caption\">As in the paper’s figure 11, as the camera sees it (the "
                "platform’s own motion included): the path of the part’s centre, from the circle to the "
                "square. Gaps are frames in which the part was not found. Frames are stored no larger than "
                "480 pixels.</p>\n";
  return section;
}

std::string first_picture(const ReportData& data) {
  std::optional<std::size_t> longest;
  double length = -1;
  for (std::size_t i = 0; i < data.runs.size(); ++i) {
    const Track& track = data.runs[i].track;
    const Ends ends = measured_ends(track);
    if (!has_picture(data.runs[i]) || !ends.any) continue;
    const double here = std::hypot(track.x_px[ends.last] - track.x_px[ends.first],
                                   track.y_px[ends.last] - track.y_px[ends.first]);
    if (here > length) {
      longest = i;
      length = here;
    }
  }
  return longest ? picture(data.runs[*longest], *longest, "first-frame") : std::string();
}

}  // namespace tribotrack::apps
