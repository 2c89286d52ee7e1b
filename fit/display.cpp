#include "fit/internal/display.h"

#include <cmath>
#include <cstdio>

namespace tribotrack::fit::internal {

std::string number(double value, int significant) {
  char text[48];
  std::snprintf(text, sizeof text, "%.*g", significant, value);
  return text;
}

std::string change_in_words(FitParameter parameter, double change, double value) {
  const std::string direction = change < 0 ? " down " : " up ";
  const double size = std::abs(change);
  if (is_relative(parameter) && value != 0)
    return to_string(parameter) + direction + number(100 * size / std::abs(value), 2) + " %";
  return to_string(parameter) + direction + number(size * display_factor(parameter), 2);
}

}  // namespace tribotrack::fit::internal
