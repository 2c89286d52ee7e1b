#include "apps/report/page/runs.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "apps/report/data/path.h"
#include "apps/report/text/text.h"

namespace tribotrack::apps {
namespace {

constexpr std::size_t most_points_drawn = 1500;  // over a picture a few hundred pixels wide

std::string phi_and_dtau(const ReportRun& run) {
  if (run.kind == "free_slide") return "free slide";
  std::string text;
  if (std::isfinite(run.phi_rad)) text += "φ = " + angle(run.phi_rad);
  if (std::isfinite(run.dtau_rad)) text += (text.empty() ? "Δτ = " : ", Δτ = ") + angle(run.dtau_rad);
  return text;
}

/// An SVG path through the measured points; a gap where the part was not measured.
std::string path_commands(const ReportRun& run) {
  const DrawnPath path = thinned(run.x_px, run.y_px, most_points_drawn);
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

Ends measured_ends(const ReportRun& run) {
  Ends ends;
  for (std::size_t i = 0; i < std::min(run.x_px.size(), run.y_px.size()); ++i) {
    if (!std::isfinite(run.x_px[i]) || !std::isfinite(run.y_px[i])) continue;
    if (!ends.any) ends.first = i;
    ends.last = i;
    ends.any = true;
  }
  return ends;
}

std::string mime_type(const std::vector<unsigned char>& bytes) {
  return bytes.size() > 1 && bytes[0] == 0xff && bytes[1] == 0xd8 ? "image/jpeg" : "image/png";
}

std::string picture(const ReportRun& run, std::size_t index) {
  const Ends ends = measured_ends(run);
  const double radius = 0.012 * std::max(run.frame_width_px, run.frame_height_px);
  std::string html = fmt::format(
      "<figure class=\"frame\"><svg viewBox=\"0 0 {0} {1}\" role=\"img\" aria-label=\"{2}\"><image "
      "href=\"data:{3};base64,{4}\" width=\"{0}\" height=\"{1}\" preserveAspectRatio=\"none\"/>",
      run.frame_width_px, run.frame_height_px, escape_html(run.name), mime_type(run.first_frame),
      base64(run.first_frame));
  if (ends.any) {
    const std::string path = path_commands(run);
    html += fmt::format("<path class=\"halo\" d=\"{0}\"/><path class=\"path\" d=\"{0}\"/>", path);
    html += fmt::format("<circle class=\"start\" cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{:.1f}\"/>",
                        run.x_px[ends.first] + 0.5, run.y_px[ends.first] + 0.5, radius);
    html += fmt::format("<rect class=\"end\" x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\"/>",
                        run.x_px[ends.last] + 0.5 - radius, run.y_px[ends.last] + 0.5 - radius, 2 * radius,
                        2 * radius);
  }
  html += fmt::format("</svg><figcaption><b>{}</b> {}<br>{}</figcaption></figure>\n", index + 1,
                      escape_html(run.name), phi_and_dtau(run));
  return html;
}

/// The recording's file, unless the run is simply named after it.
std::string video_line(const ReportRun& run) {
  const bool named_after = run.video == run.name || run.video.rfind(run.name + ".", 0) == 0;
  if (run.video.empty() || named_after) return "";
  return fmt::format("<br><span class=\"small\">{}</span>", escape_html(run.video));
}

std::string run_row(const ReportRun& run, std::size_t index) {
  std::string html = fmt::format("<tr{}>", run.failure.empty() ? "" : " class=\"failed\"");
  html += number_cell(std::to_string(index + 1));
  html += fmt::format("<td><b>{}</b>{}</td>", escape_html(run.name), video_line(run));
  if (!run.failure.empty())
    return html + "<td colspan=\"10\">failed: " + escape_html(run.failure) + "</td></tr>\n";
  html += number_cell(run.kind == "free_slide" ? "free slide" : angle(run.phi_rad));
  html += number_cell(run.kind == "free_slide" ? "–" : angle(run.dtau_rad));
  html += number_cell(value_and_sd(run.alpha_rad, run.alpha_sd_rad));
  html += number_cell(rounded(run.modelled_alpha_rad, run.alpha_sd_rad));
  html += number_cell(value_and_sd(run.v_mm_s, run.v_sd_mm_s));
  html += number_cell(rounded(run.modelled_v_mm_s, run.v_sd_mm_s));
  html += number_cell(run.cycles > 0 ? std::to_string(run.cycles) : "–");
  const bool tracked = run.frames_ok + run.frames_lost + run.frames_edge > 0;
  html += number_cell(tracked ? fmt::format("{} / {} / {}", run.frames_ok, run.frames_lost, run.frames_edge)
                              : "no video");
  html += number_cell(rounded(run.sigma_px, run.sigma_px));
  std::string time_base = std::isnan(run.frame_rate_hz) ? "" : number(run.frame_rate_hz, 6) + " Hz";
  if (!run.time_base.empty()) time_base += (time_base.empty() ? "" : ", ") + escape_html(run.time_base);
  html += cell(time_base.empty() ? "–" : time_base);
  return html + "</tr>\n";
}

std::string error_bound(const ReportStage& stage) {
  if (stage.on) return "";
  if (std::isnan(stage.error_bound_px)) return "not known";
  return stage.error_bound_px == 0 ? "none" : number(stage.error_bound_px, 2) + " px";
}

std::string stage_table(const std::vector<ReportStage>& stages) {
  std::string html =
      "<table class=\"compact plan\"><thead><tr><th>Stage</th><th>State</th><th>Reason</th><th>Error this "
      "can "
      "add</th></tr></thead><tbody>";
  for (const ReportStage& stage : stages)
    html += "<tr>" + cell(escape_html(stage.stage)) + cell(stage.on ? "done" : "<b>left out</b>") +
            cell(sentence_html(stage.reason)) + cell(error_bound(stage)) + "</tr>";
  return html + "</tbody></table>\n";
}

/// Runs whose plans are the same to the last figure.
struct PlanGroup {
  std::vector<std::size_t> runs;
  const std::vector<ReportStage>* plan = nullptr;
};

std::vector<PlanGroup> plan_groups(const std::vector<ReportRun>& runs) {
  std::vector<PlanGroup> groups;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    if (runs[i].plan.empty()) continue;
    const auto same = std::find_if(groups.begin(), groups.end(),
                                   [&](const PlanGroup& g) { return *g.plan == runs[i].plan; });
    if (same == groups.end())
      groups.push_back({{i}, &runs[i].plan});
    else
      same->runs.push_back(i);
  }
  return groups;
}

/// "1 name", or "runs 1, 3, 4" for several.
std::string group_name(const PlanGroup& group, const std::vector<ReportRun>& runs) {
  if (group.runs.size() == 1)
    return fmt::format("{} {}", group.runs.front() + 1, escape_html(runs[group.runs.front()].name));
  std::string text;
  for (const std::size_t i : group.runs) text += fmt::format("{}{}", text.empty() ? "runs " : ", ", i + 1);
  return text;
}

std::string left_out_text(const std::vector<ReportStage>& stages) {
  const auto left_out =
      std::count_if(stages.begin(), stages.end(), [](const ReportStage& s) { return !s.on; });
  return fmt::format("{} of {} stages left out", left_out, stages.size());
}

}  // namespace

std::string picture_section(const ReportData& data) {
  std::string pictures;
  for (std::size_t i = 0; i < data.runs.size(); ++i)
    if (!data.runs[i].first_frame.empty() && data.runs[i].frame_width_px > 0 &&
        data.runs[i].frame_height_px > 0)
      pictures += picture(data.runs[i], i);
  if (pictures.empty())
    return "<p class=\"left-out\">No run has a recording at hand: pictures of the paths left out.</p>\n";
  return "<h3>The paths over the first frame of each recording</h3>\n<div class=\"frames\">\n" + pictures +
         "</div>\n<p class=\"caption\">As in the paper’s figure 11, as the camera sees it (the platform’s "
         "own motion included): the path of the part’s centre, from the circle to the square. Gaps are "
         "frames in which the part was not found. Click a picture to enlarge it.</p>\n";
}

std::string run_section(const ReportData& data) {
  if (data.runs.empty()) return "";
  std::string html =
      "<section id=\"runs\"><h2>Runs</h2>\n<div class=\"wide\" tabindex=\"0\"><table "
      "class=\"runs\"><thead><tr><th "
      "class=\"n\">#</th><th>Run</th><th class=\"n\">φ</th><th class=\"n\">Δτ</th><th class=\"n\">α, "
      "rad</th><th class=\"n\">model</th><th class=\"n\">v, mm/s</th><th class=\"n\">model</th><th "
      "class=\"n\">cycles</th><th class=\"n\">frames<br>found / lost / edge</th><th class=\"n\">σ, "
      "px</th><th>Frame rate from</th></tr></thead><tbody>\n";
  for (std::size_t i = 0; i < data.runs.size(); ++i) html += run_row(data.runs[i], i);
  html +=
      "</tbody></table></div>\n<p class=\"note\">± is one standard deviation. α: direction of the "
      "displacement, counter-clockwise from the platform’s x axis; v: mean velocity over the whole cycles "
      "counted. Frames: part found, lost, or at the edge of the picture. σ: median standard deviation of a "
      "tracked position, per axis.</p>\n";
  std::string notes;
  for (std::size_t i = 0; i < data.runs.size(); ++i)
    for (const std::string& note : data.runs[i].notes)
      notes += fmt::format("<li><b>{}</b> {}: {}</li>", i + 1, escape_html(data.runs[i].name),
                           sentence_html(note));
  if (!notes.empty()) html += "<h3>Remarks</h3>\n<ul>" + notes + "</ul>\n";
  return html + "</section>\n";
}

namespace {

/// "I 1.02, P 1.31", or a dash.
std::string types_text(const vision::Audit& audit) {
  std::string text;
  for (const auto& [type, ratio] : audit.by_frame_type)
    text += fmt::format("{}{} {:.2f}", text.empty() ? "" : ", ", type, ratio);
  return text.empty() ? "–" : text;
}

}  // namespace

std::string audit_section(const ReportData& data) {
  std::string rows;
  for (std::size_t i = 0; i < data.runs.size(); ++i) {
    const vision::Audit& audit = data.runs[i].audit;
    const std::array ratios = {audit.halves_x,       audit.halves_y,    audit.checkerboard,
                               audit.high_frequency, audit.pixel_phase, audit.lag1};
    if (std::none_of(ratios.begin(), ratios.end(), [](const auto& ratio) { return ratio.has_value(); }))
      continue;
    rows +=
        "<tr>" + number_cell(std::to_string(i + 1)) + cell("<b>" + escape_html(data.runs[i].name) + "</b>");
    for (const std::optional<double>& ratio : ratios)
      rows += number_cell(ratio ? fmt::format("{:.2f}", *ratio) : "–");
    rows += cell(types_text(audit)) + number_cell(fmt::format("{:.2f}", std::sqrt(audit.white_factor))) +
            number_cell(fmt::format("{:.4f}", audit.slow_sd)) + "</tr>\n";
  }
  if (rows.empty()) return "";
  return "<section id=\"audit\"><h2>What the recordings say of σ</h2>\n<div class=\"wide\" "
         "tabindex=\"0\"><table><thead><tr><th class=\"n\">#</th><th>Run</th><th class=\"n\">left / "
         "right</th><th class=\"n\">top / bottom</th><th class=\"n\">checkerboard</th><th "
         "class=\"n\">frame to frame</th><th class=\"n\">pixel phase</th><th class=\"n\">lag "
         "1</th><th>by frame type</th><th class=\"n\">σ widened by</th><th class=\"n\">slow part added, "
         "px</th></tr></thead><tbody>\n" +
         rows +
         "</tbody></table></div>\n<p class=\"note\">Ratios of what is seen to what the tracking’s own "
         "standard deviations predict; 1 is right. The first three compare positions from complementary "
         "halves of the part’s pixels. Frame to frame: scatter of consecutive positions where the motion is "
         "slow. Pixel phase: errors with those that follow the fraction of a pixel to errors without. Lag "
         "1: correlation of consecutive errors, 0 for white noise. By frame type: the halves in the frames "
         "of a "
         "lossy recording that are coded by themselves (I) and predicted from others (P, B). The σ of all "
         "tables are the widened "
         "ones.</p>\n</section>\n";
}

std::string plan_section(const ReportData& data) {
  std::string html;
  for (const PlanGroup& group : plan_groups(data.runs))
    html += fmt::format("<details><summary>{}: {}</summary>\n{}</details>\n", group_name(group, data.runs),
                        left_out_text(*group.plan), stage_table(*group.plan));
  if (html.empty()) return "";
  return "<section id=\"plan\"><h2>Stages left out, and why</h2>\n<p class=\"note\">Before it tracks a "
         "recording, the program decides which stages its scene does not need.</p>\n" +
         html + "</section>\n";
}

}  // namespace tribotrack::apps
