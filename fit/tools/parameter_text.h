// How parameters are told to people.
#pragma once

#include <string>

#include "fit/problem.h"

namespace tribotrack::fit::internal {

/// From SI to the unit in the parameter's name (amplitude_mm: 1e3).
inline double display_factor(FitParameter parameter) {
  return parameter == FitParameter::amplitude ? 1e3 : 1;
}
/// Told in per cent of its own value.
inline bool is_relative(FitParameter parameter) {
  return parameter == FitParameter::mu1 || parameter == FitParameter::mu2 ||
         parameter == FitParameter::amplitude || parameter == FitParameter::angular_frequency ||
         parameter == FitParameter::scale;
}
/// `significant` digits, trailing zeros dropped.
std::string number(double value, int significant = 3);
/// "mu1 up 1.2 %", "phase_lag_rad down 0.021"
std::string change_in_words(FitParameter parameter, double change, double value);

}  // namespace tribotrack::fit::internal
