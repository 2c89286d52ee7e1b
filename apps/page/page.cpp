#include "apps/page/page.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "apps/figures/axes.h"
#include "apps/figures/figure_csv.h"
#include "apps/page/assets/embedded_assets.h"
#include "apps/page/filling.h"
#include "apps/page/text.h"

namespace tribotrack::apps {

std::string fill_template(std::string_view page, const PageParts& parts) {
  std::string filled;
  std::size_t position = 0;
  while (true) {
    const std::size_t open = page.find("{{", position);
    if (open == std::string_view::npos) break;
    const std::size_t close = page.find("}}", open);
    const auto part = parts.find(page.substr(open + 2, close - open - 2));
    if (close == std::string_view::npos || part == parts.end())
      throw std::logic_error("a page's template names a part that the page does not have");
    filled += page.substr(position, open - position);
    filled += part->second;
    position = close + 2;
  }
  return filled += page.substr(position);
}

std::string json_for_script(const Json& json) {
  const std::string text = json.dump(-1, ' ', false, Json::error_handler_t::replace);
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

namespace {

constexpr int kNarrowest = 480;  // px, of a figure that is narrower than the text

/// JSON inside a script element.
std::string figures_json(const std::vector<Figure>& figures) {
  Json list = Json::array();
  for (const Figure& figure : figures) list.push_back(json_of(figure));
  return json_for_script(list);
}

std::string contents(const std::vector<PageSection>& sections) {
  std::string html = "<nav class=\"contents\" aria-label=\"Contents\"><ol>";
  for (const PageSection& section : sections)
    html += fmt::format("<li><a href=\"#{}\">{}</a></li>", section.id, escape_html(section.heading));
  return html + "</ol></nav>";
}

std::string body(const std::vector<PageSection>& sections) {
  std::string html;
  bool appendix = false;
  for (const PageSection& section : sections) {
    const bool begins = section.appendix && !appendix;
    appendix = appendix || section.appendix;
    html += fmt::format("<section id=\"{}\"{}><h2>{}</h2>\n{}</section>\n", section.id,
                        begins ? " class=\"appendix\"" : "", escape_html(section.heading), section.html);
  }
  return html;
}

/// Letters, digits and a few signs: a name for files on any system.
std::string file_name(const std::string& name) {
  std::string safe;
  for (const char c : name)
    safe += (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || c == '_' || c == '.'
                ? c
                : '-';
  return safe.empty() ? "tribotrack" : safe;
}

}  // namespace

std::string html_of(Page page) {
  for (Figure& figure : page.figures) settle_axes(figure);
  const std::string name = file_name(page.name);
  const std::string title = escape_html(page.title), subtitle = escape_html(page.subtitle);
  const std::string list = contents(page.sections), sections = body(page.sections);
  const std::string figures = figures_json(page.figures);
  const EmbeddedAssets& assets = embedded_assets();
  return fill_template(assets.page_template, {{"name", name},
                                              {"title", title},
                                              {"subtitle", subtitle},
                                              {"style", assets.page_css},
                                              {"first", page.first},
                                              {"contents", list},
                                              {"body", sections},
                                              {"figures", figures},
                                              {"plotly", assets.plotly_js},
                                              {"drawing", assets.figures_js},
                                              {"script", assets.page_js}});
}

std::string figure_box(const Figure& figure) {
  return fmt::format(
      "<figure class=\"plot\" id=\"figure-{0}\"{4}><div id=\"plot-{0}\" class=\"box\" role=\"img\" "
      "tabindex=\"0\" "
      "aria-label=\"{1}\"></div><figcaption><b>{2}.</b> {3}</figcaption></figure>\n",
      figure.id, escape_html(figure.alternative.empty() ? figure.title : figure.alternative),
      escape_html(figure.title), figure.caption,
      figure.width < 1 ? fmt::format(" style=\"max-width:max({:.0f}%,{}px)\"", 100 * figure.width, kNarrowest)
                       : "");
}

std::string figure_box(const std::vector<Figure>& figures, const std::string& id) {
  const auto found = std::ranges::find(figures, id, &Figure::id);
  return found == figures.end() ? std::string() : figure_box(*found);
}

}  // namespace tribotrack::apps
