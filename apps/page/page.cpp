// A self-contained HTML page: its parts, and numbers, angles and text as it writes them.
#include "apps/page/page.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/algorithm/string/replace.hpp>
#include <cctype>
#include <cmath>
#include <iterator>
#include <map>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "apps/page/assets/embedded_assets.h"
#include "apps/page/text.h"
#include "apps/text/number_text.h"

namespace tribotrack::apps {

std::string escape_html(std::string_view text) {
  std::string escaped;
  for (const char c : text) {
    constexpr std::string_view kSigns = "&<>\"'";
    constexpr const char* kEntities[] = {"&amp;", "&lt;", "&gt;", "&quot;", "&#39;"};
    const std::size_t sign = kSigns.find(c);
    escaped += sign == kSigns.npos ? std::string{c} : kEntities[sign];
  }
  return escaped;
}

std::string cell(const std::string& html) {
  return fmt::format("<td>{}</td>", html);
}

std::string number_cell(const std::string& html) {
  return fmt::format("<td class=\"n\">{}</td>", html);
}

std::string table(const std::string& id, const std::string& classes, const std::vector<std::string>& headings,
                  const std::string& rows) {
  std::string html = fmt::format(R"(<div class="wide"><table id="{}" class="{}"><thead><tr>)", id, classes);
  for (const std::string& heading : headings)
    html += heading.empty()            ? "<td></td>"
            : heading.starts_with('>') ? "<th class=\"n\">" + heading.substr(1) + "</th>"
                                       : "<th>" + heading + "</th>";
  return html + "</tr></thead><tbody>\n" + rows + "</tbody></table></div>\n";
}

namespace {

/// A true minus sign, which a page does not break a line after.
std::string with_minus_sign(std::string digits) {
  if (!digits.empty() && digits.front() == '-') digits.replace(0, 1, "−");
  return digits;
}

bool usable(double sd) {
  return std::isfinite(sd) && sd > 0;
}

bool in_word(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) || c == '_';
}

bool digit_at(std::string_view text, std::size_t at) {
  return at < text.size() && std::isdigit(static_cast<unsigned char>(text[at]));
}

/// Words and signs of sentences and their symbols; the longer of two that begin alike stands first.
constexpr std::pair<std::string_view, std::string_view> symbols[] = {{"phase_lag_rad", "lag"},
                                                                     {"mu1/mu2", "μ₁/μ₂"},
                                                                     {"mu1", "μ₁"},
                                                                     {"mu2", "μ₂"},
                                                                     {"mu", "μ"},
                                                                     {"chi2", "χ²"},
                                                                     {"dtau", "Δτ"},
                                                                     {"phi", "φ"},
                                                                     {"alpha", "α"},
                                                                     {"omega^2", "ω²"},
                                                                     {"omega", "ω"},
                                                                     {"A_e", "Aₑ"},
                                                                     {"rad/s^2", "rad/s²"},
                                                                     {"+-", "±"},
                                                                     {"->", "→"},
                                                                     {"pi", "π"}};

/// Does `word` stand alone at `at`, not inside a longer name, a file's name or a path? A number may divide
/// it: "pi/2".
bool stands_alone(std::string_view text, std::size_t at, std::string_view word) {
  if (!in_word(word.front())) return true;
  const std::size_t end = at + word.size();
  const bool name_before = at > 0 && (in_word(text[at - 1]) || text[at - 1] == '/' || text[at - 1] == '.');
  const bool name_after =
      end < text.size() && (in_word(text[end]) || (text[end] == '/' && !digit_at(text, end + 1)) ||
                            (text[end] == '.' && end + 1 < text.size() && in_word(text[end + 1])));
  return !name_before && !name_after;
}

}  // namespace

std::string number(double value, int digits) {
  if (std::isnan(value)) return "–";
  if (std::isinf(value)) return value > 0 ? "∞" : "−∞";
  return with_minus_sign(fmt::format("{:.{}g}", value, digits));
}

std::string rounded(double value, double sd) {
  if (!std::isfinite(value) || !usable(sd)) return number(value);
  return with_minus_sign(rounded_to_sd(value, sd));
}

std::string quoted_value(double value, double sd) {
  return with_minus_sign(quoted(value, sd));
}

std::string quoted_cell(double value, double sd) {
  if (std::isnan(value)) return number_cell("–");
  return fmt::format("<td class=\"n\" data-v=\"{}\" data-sd=\"{}\">{}</td>", exact(value), exact(sd),
                     usable(sd) ? quoted_value(value, sd) : number(value));
}

std::string interval_text(double low, double high, double sd) {
  if (std::isnan(low) || std::isnan(high)) return "–";
  const auto end = [&](double value) {
    return std::isfinite(value) ? with_minus_sign(rounded_end(value, low, high, sd)) : number(value);
  };
  return end(low) + " to " + end(high);
}

std::string sentence_html(std::string_view sentence) {
  std::string text;
  for (std::size_t at = 0; at < sentence.size();) {
    const auto* symbol = std::find_if(std::begin(symbols), std::end(symbols), [&](const auto& candidate) {
      return sentence.substr(at).starts_with(candidate.first) && stands_alone(sentence, at, candidate.first);
    });
    if (symbol == std::end(symbols)) {
      text += sentence[at++];
    } else {
      text += symbol->second;
      at += symbol->first.size();
    }
  }
  return escape_html(text);
}

std::string html_list(const std::vector<std::string>& sentences) {
  std::string html = "<ul>";
  for (const std::string& sentence : sentences) html += "<li>" + sentence_html(sentence) + "</li>";
  return html + "</ul>\n";
}

std::string angle(double rad) {
  if (!std::isfinite(rad)) return number(rad);
  const double twelfths = rad * 12 / std::numbers::pi;
  const long whole = std::lround(twelfths);
  if (std::abs(twelfths - static_cast<double>(whole)) > 1e-4 * 12 / std::numbers::pi || std::abs(whole) > 480)
    return number(rad) + " rad";
  return multiple_of_pi(whole, 12);
}

ParameterText parameter_text(const std::string& key) {
  static const std::map<std::string, ParameterText> known = {
      {"mu1", {"μ₁", "", "friction coefficient while the actuator is off"}},
      {"mu2", {"μ₂", "", "effective friction coefficient while the actuator is on"}},
      {"phase_lag_rad",
       {"lag", "rad",
        "how much later than commanded the friction changes, as an angle of the platform’s turn"}},
      {"delay_s", {"delay", "s", "how much later than commanded the friction changes, as a time"}},
      {"amplitude_mm", {"A", "mm", "amplitude of the platform’s motion"}},
      {"amplitude_y_mm", {"Ay", "mm", "amplitude of the platform’s motion along y"}},
      {"angular_frequency_rad_s", {"ω", "rad/s", "angular frequency of the platform"}},
      {"phase_shift_rad", {"ε", "rad", "phase shift between the platform’s two axes"}},
      {"diameter_mm", {"diameter", "mm", "diameter of the part"}},
      {"height_mm", {"height", "mm", "height of the part"}},
      {"gravity_m_s2", {"g", "m/s²", "acceleration of gravity"}},
      {"mm_per_px", {"scale", "mm/px", "millimetres per pixel"}},
      {"scale", {"scale", "", "factor on every measured length; 1 = as measured"}},
      {"tilt_x_rad", {"tilt x", "rad", "slope of the platform towards +x"}},
      {"tilt_y_rad", {"tilt y", "rad", "slope of the platform towards +y"}},
      {"phi_rad", {"φ", "rad", "phase of the pulse"}},
      {"dtau_rad", {"Δτ", "rad", "width of the pulse"}},
      {"xi_axis_rad", {"camera axis", "rad", "direction of the displacement at the sensor’s pulse"}},
      {"friction_law", {"friction law", "", "law of friction"}},
  };
  const auto found = known.find(key);
  return found != known.end() ? found->second : ParameterText{escape_html(key), "", ""};
}

std::string base64(const std::vector<unsigned char>& bytes) {
  static constexpr std::string_view alphabet =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t left = std::min<std::size_t>(3, bytes.size() - i);
    unsigned block = 0;
    for (std::size_t k = 0; k < 3; ++k) block = block << 8 | (k < left ? bytes[i + k] : 0u);
    for (std::size_t k = 0; k < 4; ++k) text += k <= left ? alphabet[block >> (18 - 6 * k) & 63u] : '=';
  }
  return text;
}

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
  return boost::replace_all_copy(json.dump(-1, ' ', false, Json::error_handler_t::replace), "<", "\\u003c");
}

namespace {

constexpr int kNarrowest = 480;  // px, of a figure that is narrower than the text

/// JSON inside a script element.
std::string figures_json(const std::vector<Figure>& figures) {
  Json list = Json::array();
  for (const Figure& figure : figures) list.push_back(plotly_json(figure));
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
      "tabindex=\"0\" aria-label=\"{1}\"></div><figcaption><b>{2}.</b> {3}</figcaption></figure>\n",
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
