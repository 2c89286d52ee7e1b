#pragma once
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <type_traits>
/// The value, times VARY_BY if VARY names it.
template <class Number>
Number varied(const char* name, Number value) {
  const char* which = std::getenv("VARY");
  if (!which || std::strcmp(which, name) != 0) return value;
  const double by = std::atof(std::getenv("VARY_BY")), out = static_cast<double>(value) * by;
  if constexpr (std::is_integral_v<Number>) {
    const auto rounded = static_cast<Number>(std::llround(out));
    return rounded != value ? rounded
                            : static_cast<Number>(by > 1      ? value + 1
                                                  : value > 1 ? value - 1
                                                              : value);
  } else {
    return static_cast<Number>(out);
  }
}
