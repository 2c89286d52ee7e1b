#include "apps/report/text/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>

namespace tribotrack::apps {

std::string escape_html(std::string_view text) {
  std::string escaped;
  escaped.reserve(text.size());
  for (const char c : text) {
    switch (c) {
      case '&':
        escaped += "&amp;";
        break;
      case '<':
        escaped += "&lt;";
        break;
      case '>':
        escaped += "&gt;";
        break;
      case '"':
        escaped += "&quot;";
        break;
      case '\'':
        escaped += "&#39;";
        break;
      default:
        escaped += c;
    }
  }
  return escaped;
}

std::string cell(const std::string& html) {
  return fmt::format("<td>{}</td>", html);
}

std::string number_cell(const std::string& html) {
  return fmt::format("<td class=\"n\">{}</td>", html);
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

}  // namespace

std::string number(double value, int digits) {
  if (std::isnan(value)) return "–";
  if (std::isinf(value)) return value > 0 ? "∞" : "−∞";
  return with_minus_sign(fmt::format("{:.{}g}", value, digits));
}

std::string rounded_to_sd(double value, double sd) {
  if (!std::isfinite(value) || !usable(sd)) return number(value);
  const int decimals = 1 - static_cast<int>(std::floor(std::log10(sd)));
  if (decimals > 9) return number(value, 9);
  return with_minus_sign(fmt::format("{:.{}f}", value, std::max(decimals, 0)));
}

std::string interval_words(const ReportInterval& range, double sd) {
  if (std::isnan(range.low) || std::isnan(range.high)) return "–";
  return rounded_to_sd(range.low, sd) + " to " + rounded_to_sd(range.high, sd);
}

std::string html_list(const std::vector<std::string>& sentences) {
  std::string html = "<ul>";
  for (const std::string& sentence : sentences) html += "<li>" + escape_html(sentence) + "</li>";
  return html + "</ul>\n";
}

std::string value_and_sd(double value, double sd) {
  if (!std::isfinite(value) || !usable(sd)) return number(value);
  return rounded_to_sd(value, sd) + " ± " + rounded_to_sd(sd, sd);
}

std::string angle(double rad) {
  if (!std::isfinite(rad)) return number(rad);
  const double twelfths = rad * 12 / std::numbers::pi;
  const long whole = std::lround(twelfths);
  if (std::abs(twelfths - static_cast<double>(whole)) > 1e-4 * 12 / std::numbers::pi || std::abs(whole) > 480)
    return number(rad) + " rad";
  if (whole == 0) return "0";
  const long divisor = std::gcd(whole, 12L);
  const long top = std::abs(whole) / divisor;
  const long bottom = 12 / divisor;
  return fmt::format("{}{}π{}", whole < 0 ? "−" : "", top == 1 ? "" : std::to_string(top),
                     bottom == 1 ? "" : fmt::format("/{}", bottom));
}

ParameterWords parameter_words(const std::string& key) {
  static const std::map<std::string, ParameterWords> known = {
      {"mu1", {"μ<sub>1</sub>", "", "friction coefficient while the actuator is off"}},
      {"mu2", {"μ<sub>2</sub>", "", "effective friction coefficient while the actuator is on"}},
      {"phase_lag_rad",
       {"lag", "rad",
        "how much later than commanded the friction changes, as an angle of the platform’s turn"}},
      {"delay_s", {"delay", "s", "how much later than commanded the friction changes, as a time"}},
      {"amplitude_mm", {"A", "mm", "amplitude of the platform’s motion"}},
      {"amplitude_y_mm", {"A<sub>y</sub>", "mm", "amplitude of the platform’s motion along y"}},
      {"angular_frequency_rad_s", {"ω", "rad/s", "angular frequency of the platform"}},
      {"phase_shift_rad", {"ε", "rad", "phase shift between the platform’s two axes"}},
      {"diameter_mm", {"diameter", "mm", "diameter of the part"}},
      {"diameter_sd_mm", {"sd of diameter", "mm", "standard deviation of the part’s diameter"}},
      {"height_mm", {"height", "mm", "height of the part"}},
      {"gravity_m_s2", {"g", "m/s²", "acceleration of gravity"}},
      {"mm_per_px", {"scale", "mm/px", "millimetres per pixel"}},
      {"scale", {"scale", "", "factor on every measured length; 1 = as measured"}},
      {"tilt_x_rad", {"tilt<sub>x</sub>", "rad", "slope of the platform towards +x"}},
      {"tilt_y_rad", {"tilt<sub>y</sub>", "rad", "slope of the platform towards +y"}},
  };
  const auto found = known.find(key);
  return found != known.end() ? found->second : ParameterWords{escape_html(key), "", ""};
}

std::string observable_words(const std::string& observable) {
  static const std::map<std::string, std::string> known = {
      {"alpha_rad", "α (rad)"}, {"v_mm_s", "v (mm/s)"}, {"dx_mm", "dx (mm)"},   {"dy_mm", "dy (mm)"},
      {"x_mm", "x (mm)"},       {"y_mm", "y (mm)"},     {"rms_mm", "rms (mm)"}, {"rms_px", "rms (px)"},
  };
  const auto found = known.find(observable);
  return found != known.end() ? found->second : observable;
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

}  // namespace tribotrack::apps
