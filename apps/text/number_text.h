// Numbers as text, for tables that machines read.
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

}  // namespace tribotrack::apps
