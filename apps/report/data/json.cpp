#include "apps/report/data/json.h"

#include <limits>

namespace tribotrack::apps {

ReportInterval interval_of(const JsonPlace& place) {
  constexpr double open = std::numeric_limits<double>::infinity();
  if (!place.value.is_array() || place.value.size() != 2) place.refuse("a list of two numbers");
  const auto end = [&](std::size_t k, double if_open) {
    return place.value[k].is_null() ? if_open : place.at(k).number();
  };
  const ReportInterval interval{end(0, -open), end(1, open)};
  if (interval.low > interval.high) place.refuse("an interval, the low end first");
  return interval;
}

double sd_of(const JsonPlace& place) {
  const double sd = place.number_or_null();
  if (sd < 0) place.refuse("0 or more");
  return sd;
}

}  // namespace tribotrack::apps
