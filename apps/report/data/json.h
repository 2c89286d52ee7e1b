// Values out of result files, for the page: what a file does not hold is NaN, an empty text, an empty list.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "apps/program/errors.h"
#include "apps/report/data/data.h"
#include "apps/text/json.h"

namespace tribotrack::apps {

/// Runs `read`; what it misses becomes an InvalidInput that names the file, too.
template <class Read>
void reading(const std::filesystem::path& file, const Read& read) {
  try {
    read();
  } catch (const WrongContent& error) {
    throw InvalidInput(file.string() + ": " + error.what() +
                       "; it is not what `tribotrack run` writes: run it again");
  }
}

/// NaN where there is no number.
inline double number_at(const JsonPlace& place, const std::string& key) {
  return place.number(key, no_value);
}

inline std::vector<double> numbers_at(const JsonPlace& place, const std::string& key) {
  std::vector<double> values;
  for (const JsonPlace& item : place.items(key)) values.push_back(item.number_or_null());
  return values;
}

/// A standard deviation: not below 0, NaN for null.
double sd_of(const JsonPlace& place);

/// [low, high]; null is an open end.
ReportInterval interval_of(const JsonPlace& place);

/// No interval where the key is absent.
inline ReportInterval interval_at(const JsonPlace& place, const std::string& key) {
  const auto found = place.find(key);
  return found ? interval_of(*found) : ReportInterval{};
}

}  // namespace tribotrack::apps
