// Numbers as text: every digit for tables that machines read, rounded to the sd for people.
#pragma once

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>
#include <string>

#include "fit/rounding.h"

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

/// The number that compact()'s text reads back as; NaN for what is not finite. What is computed from a value
/// just measured and from the same value read back from its table is then the same, bit for bit.
inline double as_written(double value) {
  if (!std::isfinite(value)) return std::numeric_limits<double>::quiet_NaN();
  fmt::memory_buffer text;
  fmt::format_to(std::back_inserter(text), "{:.10g}", value);
  std::from_chars(text.begin(), text.end(), value);
  return value;
}

using fit::quoted;
using fit::rounded_end;
using fit::rounded_to_sd;

}  // namespace tribotrack::apps
