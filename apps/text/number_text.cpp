#include "apps/text/number_text.h"

#include <algorithm>
#include <cstdlib>

namespace tribotrack::apps {

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

}  // namespace tribotrack::apps
