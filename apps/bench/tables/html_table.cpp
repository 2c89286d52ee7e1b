#include "apps/bench/tables/html_table.h"

#include <fmt/format.h>

#include "apps/page/text.h"

namespace tribotrack::bench {
namespace {

/// Text cells are padded.
std::string_view trimmed(std::string_view text) {
  const auto begin = text.find_first_not_of(' ');
  return begin == std::string_view::npos ? "" : text.substr(begin, text.find_last_not_of(' ') - begin + 1);
}

std::string cell_html(const char* element, const HtmlCell& cell) {
  const std::string_view text = trimmed(cell.text);
  std::string attributes = cell.number ? " class=\"n\"" : "";
  if (!cell.exact.empty() && cell.exact != text)
    attributes += fmt::format(" data-v=\"{}\"", apps::escape_html(cell.exact));
  std::string html = apps::sentence_html(text);
  if (html.ends_with(" us")) html.replace(html.size() - 2, 2, "µs");
  return fmt::format("<{0}{1}>{2}</{0}>", element, attributes, html);
}

}  // namespace

std::string html_table(std::string_view id, const std::vector<HtmlCell>& headings,
                       const std::vector<std::vector<HtmlCell>>& rows) {
  std::string html = fmt::format("<div class=\"wide\"><table id=\"{}\" class=\"compact\"><thead><tr>", id);
  for (const HtmlCell& heading : headings) html += cell_html("th", heading);
  html += "</tr></thead><tbody>\n";
  for (const std::vector<HtmlCell>& row : rows) {
    html += "<tr>";
    for (const HtmlCell& cell : row) html += cell_html("td", cell);
    html += "</tr>\n";
  }
  return html + "</tbody></table></div>\n";
}

}  // namespace tribotrack::bench
