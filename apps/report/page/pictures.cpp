#include "apps/report/page/pictures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "apps/figures/thinning.h"
#include "apps/page/text.h"

namespace tribotrack::apps {
namespace {

constexpr std::size_t most_points_drawn = 500;  // over a picture a few hundred pixels wide

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

/// `place`: an id of its own on the page.
std::string picture(const ReportRun& run, std::size_t index, const std::string& place) {
  const Ends ends = measured_ends(run);
  const double radius = 0.012 * std::max(run.frame_width_px, run.frame_height_px);
  std::string html = fmt::format(
      "<figure class=\"frame\" id=\"{5}\"><svg viewBox=\"0 0 {0} {1}\" role=\"img\" aria-label=\"path of the "
      "part in run {2}\"><image "
      "href=\"data:{3};base64,{4}\" width=\"{0}\" height=\"{1}\" preserveAspectRatio=\"none\"/>",
      run.frame_width_px, run.frame_height_px, escape_html(run.name), mime_type(run.first_frame),
      base64(run.first_frame), place);
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

bool has_picture(const ReportRun& run) {
  return !run.first_frame.empty() && run.frame_width_px > 0 && run.frame_height_px > 0;
}

}  // namespace

std::string pictures_of_runs(const ReportData& data) {
  std::string pictures;
  for (std::size_t i = 0; i < data.runs.size(); ++i)
    if (has_picture(data.runs[i])) pictures += picture(data.runs[i], i, fmt::format("frame-{}", i + 1));
  if (pictures.empty())
    return "<p class=\"left-out\">No run has a recording at hand: pictures of the paths left out.</p>\n";
  return "<div class=\"frames\">\n" + pictures +
         "</div>\n<p class=\"caption\">As in the paper’s figure 11, as the camera sees it (the platform’s "
         "own motion included): the path of the part’s centre, from the circle to the square. Gaps are "
         "frames in which the part was not found. Frames are stored no larger than 480 pixels.</p>\n";
}

std::string first_picture(const ReportData& data) {
  std::optional<std::size_t> longest;
  double length = -1;
  for (std::size_t i = 0; i < data.runs.size(); ++i) {
    const ReportRun& run = data.runs[i];
    const Ends ends = measured_ends(run);
    if (!has_picture(run) || !ends.any) continue;
    const double here =
        std::hypot(run.x_px[ends.last] - run.x_px[ends.first], run.y_px[ends.last] - run.y_px[ends.first]);
    if (here > length) {
      longest = i;
      length = here;
    }
  }
  return longest ? picture(data.runs[*longest], *longest, "first-frame") : std::string();
}

}  // namespace tribotrack::apps
