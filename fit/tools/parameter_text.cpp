#include "fit/tools/parameter_text.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

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
  if (is_relative(parameter) && value != 0)
    return to_string(parameter) + direction + number(100 * size / std::abs(value), 2) + " %";
  const std::string text = to_string(parameter) + direction + number(size * display_factor(parameter), 2);
  const bool angle = parameter == FitParameter::lag || parameter == FitParameter::tilt_x ||
                     parameter == FitParameter::tilt_y || parameter == FitParameter::slope;
  return angle ? text + " (" + number(size * 180 / std::numbers::pi, 2) + " deg)" : text;
}

}  // namespace tribotrack::fit::internal
