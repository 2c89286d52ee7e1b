#include "apps/report/page/page.h"

#include <fmt/format.h>

#include <functional>
#include <map>
#include <stdexcept>

#include "apps/report/assets/embedded_assets.h"
#include "apps/report/page/check.h"
#include "apps/report/page/figures.h"
#include "apps/report/page/parameters/next.h"
#include "apps/report/page/platform.h"
#include "apps/report/page/rotation.h"
#include "apps/report/page/runs.h"
#include "apps/report/page/sections.h"
#include "apps/report/text/text.h"

namespace tribotrack::apps {
namespace {

using Parts = std::map<std::string, std::string_view, std::less<>>;

/// Replaces each {{name}} of the template once, in one pass: what is put in is not looked at again.
std::string fill_template(std::string_view page, const Parts& parts) {
  std::string filled;
  std::size_t position = 0;
  while (true) {
    const std::size_t open = page.find("{{", position);
    if (open == std::string_view::npos) break;
    const std::size_t close = page.find("}}", open);
    const auto part = parts.find(page.substr(open + 2, close - open - 2));
    if (close == std::string_view::npos || part == parts.end())
      throw std::logic_error("page.html names a part that the report does not have");
    filled += page.substr(position, open - position);
    filled += part->second;
    position = close + 2;
  }
  return filled += page.substr(position);
}

std::string trajectory_section(const ReportData& data) {
  return "<section id=\"trajectories\"><h2>Trajectories</h2>\n" + trajectory_plot(data) +
         picture_section(data) + "</section>\n";
}

/// What the page is of, and by which program.
std::string subtitle_of(const ReportData& data) {
  std::string text;
  if (!data.runs.empty())
    text =
        fmt::format("{} {} run{}, ", data.parameters.empty() ? "Measurements of" : "Friction parameters from",
                    data.runs.size(), data.runs.size() == 1 ? "" : "s");
  text += "tribotrack";
  if (!data.program_version.empty()) text += " " + escape_html(data.program_version);
  return text;
}

}  // namespace

std::string page_of(const ReportData& data) {
  const std::string title = escape_html(data.title);
  const std::string body = verdict_section(data) + parameter_section(data) + check_section(data) +
                           next_section(data) + dependence_section(data) + trajectory_section(data) +
                           platform_section(data) + residual_section(data) + slide_section(data) +
                           run_section(data) + rotation_section(data) + audit_section(data) +
                           plan_section(data) + provenance_section(data);
  const std::string subtitle = subtitle_of(data);
  const std::string figures = figures_json(data);
  const EmbeddedAssets& assets = embedded_assets();
  return fill_template(assets.page_template, {{"title", title},
                                              {"subtitle", subtitle},
                                              {"style", assets.report_css},
                                              {"body", body},
                                              {"figures", figures},
                                              {"plotly", assets.plotly_js},
                                              {"script", assets.report_js}});
}

}  // namespace tribotrack::apps
