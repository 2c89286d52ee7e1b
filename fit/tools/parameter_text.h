// Parameters in messages: units, digits, changes.
#pragma once

#include <string>

#include "fit/problem.h"

namespace tribotrack::fit::internal {

/// From SI to the unit in the parameter's name (amplitude_mm: 1e3).
inline double display_factor(FitParameter parameter) {
  return parameter == FitParameter::amplitude ? 1e3 : 1;
}
/// `significant` digits, trailing zeros dropped.
std::string number(double value, int significant = 3);
/// "p = 0.02"; "p < 1e-300" where it underflows: small, not zero.
std::string chance_text(double p_value);
/// "mu1 up 1.2 %", "phase_lag_rad down 0.021 (1.2 deg)"
std::string change_text(FitParameter parameter, double change, double value);

}  // namespace tribotrack::fit::internal
