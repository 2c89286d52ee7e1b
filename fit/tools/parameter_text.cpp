#include "fit/tools/parameter_text.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>

#include "fit/rounding.h"
#include "fit/tools/parameters.h"

namespace tribotrack::fit::internal {

std::string number(double value, int significant) {
  return fmt::format("{:.{}g}", value, significant);
}

std::string chance_text(double p_value) {
  return p_value > 0 ? "p = " + number(p_value, 2) : "p < 1e-300";
}

std::string change_text(FitParameter parameter, double change, double value) {
  const std::string direction = change < 0 ? " down " : " up ";
  const double size = std::abs(change);
  const ParameterFacts& known = facts(parameter);
  if (known.is_relative() && value != 0)
    return to_string(parameter) + direction + number(100 * size / std::abs(value), 2) + " %";
  const std::string text = to_string(parameter) + direction + number(size * display_factor(parameter), 2);
  return known.is_angle() ? text + " (" + number(size * 180 / std::numbers::pi, 2) + " deg)" : text;
}

}  // namespace tribotrack::fit::internal

namespace tribotrack::fit {
namespace {

/// Of the number rounded to two digits: 0.0996 counts as 0.10.
int exponent_of(double value) {
  const std::string text = fmt::format("{:.1e}", value);
  return std::atoi(text.c_str() + text.find('e') + 1);
}

}  // namespace

std::string rounded_to_sd(double value, double sd) {
  if (!std::isfinite(value) || !std::isfinite(sd) || !(sd > 0)) return fmt::format("{:.4g}", value);
  const int exponent = exponent_of(sd);
  if (exponent >= -8 && exponent < 5) return fmt::format("{:.{}f}", value, std::max(1 - exponent, 0));
  // Very small or large: a power of ten keeps the zeros out.
  const int digits = value == 0 ? 0 : std::max(exponent_of(std::abs(value)) - exponent + 1, 0);
  return fmt::format("{:.{}e}", value, digits);
}

std::string quoted(double value, double sd) {
  if (!std::isfinite(value) || !std::isfinite(sd) || sd < 0) return "not determined";
  if (sd == 0) return fmt::format("{:.4g}", value);
  const std::string text = rounded_to_sd(value, sd), error = rounded_to_sd(sd, sd);
  std::string digits;
  if (const auto power = error.find('e'); power != std::string::npos) {
    // Both with the value's power of ten: the error's digits are those of its last two places.
    const std::string two = fmt::format("{:.0f}", sd / std::pow(10.0, exponent_of(sd) - 1));
    const auto end = text.find('e');
    return fmt::format("{}({}){}", text.substr(0, end), two,
                       end == std::string::npos ? "" : text.substr(end));
  }
  // In units of the value's last place: "0.0029" becomes "29", "1.2" becomes "12".
  for (const char c : error)
    if (c != '.' && (c != '0' || !digits.empty())) digits += c;
  return fmt::format("{}({})", text, digits);
}

std::string rounded_end(double end, double low, double high, double sd) {
  if (!std::isfinite(end)) return "open";
  const double half_width = 0.5 * (high - low);
  const bool wide = std::isfinite(half_width) && half_width > 0, known = std::isfinite(sd) && sd > 0;
  return rounded_to_sd(end, !wide ? sd : known ? std::min(sd, half_width) : half_width);
}

}  // namespace tribotrack::fit
