// Numbers as text: every digit for tables that machines read, rounded to the sd for people.
#pragma once

#include <fmt/format.h>

#include <cmath>
#include <optional>
#include <string>

namespace tribotrack::apps {

/// Shortest text that reads back as the same double; empty for NaN (an empty cell).
inline std::string exact(double value) {
  return std::isfinite(value) ? fmt::format("{}", value) : std::string();
}

/// Ten significant digits: finer than any measurement here, shorter than exact().
inline std::string compact(double value) {
  return std::isfinite(value) ? fmt::format("{:.10g}", value) : std::string();
}

inline std::string compact(const std::optional<double>& value) {
  return value ? compact(*value) : std::string();
}

/// A value rounded to the place of the second significant digit of its sd, trailing zeros kept: (0.100123,
/// 0.00031) gives "0.10012". rounded_to_sd(sd, sd) is the sd itself. Four significant digits without a usable
/// sd.
std::string rounded_to_sd(double value, double sd);

}  // namespace tribotrack::apps
