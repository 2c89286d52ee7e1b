#include "apps/text/angle.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <numbers>

namespace tribotrack::apps {

namespace {

std::string without_spaces(std::string_view text) {
  std::string kept;
  for (const char c : text)
    if (c != ' ' && c != '\t') kept += c;
  return kept;
}

}  // namespace

std::optional<double> parse_number(std::string_view text) {
  if (!text.empty() && text.front() == '+') text.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

std::optional<double> parse_angle(std::string_view text) {
  const std::string compact = without_spaces(text);
  if (compact.ends_with("deg")) {
    const auto degrees = parse_number(std::string_view(compact).substr(0, compact.size() - 3));
    return degrees ? std::optional(*degrees * std::numbers::pi / 180) : std::nullopt;
  }
  const auto pi_at = compact.find("pi");
  if (pi_at == std::string::npos) return parse_number(compact);

  std::string factor = compact.substr(0, pi_at);
  std::string divisor = compact.substr(pi_at + 2);
  if (!factor.empty() && factor.back() == '*') {
    factor.pop_back();
    if (factor.empty()) return std::nullopt;
  }
  double value = std::numbers::pi;
  if (factor == "-") {
    value = -value;
  } else if (!factor.empty() && factor != "+") {
    const auto number = parse_number(factor);
    if (!number) return std::nullopt;
    value *= *number;
  }
  if (divisor.empty()) return value;
  if (divisor.front() != '/') return std::nullopt;
  const auto number = parse_number(std::string_view(divisor).substr(1));
  if (!number || *number == 0) return std::nullopt;
  return value / *number;
}

std::string angle_slip(double radians) {
  if (std::abs(radians) <= 4 * std::numbers::pi) return "";
  return fmt::format("must lie within two turns (4 pi rad), not {}: degrees? write \"{}deg\"", radians,
                     radians);
}

}  // namespace tribotrack::apps
