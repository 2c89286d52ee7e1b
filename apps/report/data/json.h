// Values out of result files that may be absent: what is not there is no value, an empty word, an empty list.
#pragma once

#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "apps/files/meta_file.h"
#include "apps/report/data/data.h"

namespace tribotrack::apps {

/// NaN where there is no number.
inline double number_at(const Json& object, const std::string& key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_number() ? found->get<double>() : no_value;
}

inline std::string word_at(const Json& object, const std::string& key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_string() ? found->get<std::string>() : std::string();
}

inline std::vector<double> numbers_at(const Json& object, const std::string& key) {
  std::vector<double> values;
  if (const auto found = object.find(key); found != object.end())
    for (const Json& item : *found) values.push_back(item.is_number() ? item.get<double>() : no_value);
  return values;
}

inline std::vector<std::string> sentences_at(const Json& object, const std::string& key) {
  std::vector<std::string> values;
  if (const auto found = object.find(key); found != object.end() && found->is_array())
    for (const Json& item : *found) values.push_back(item.get<std::string>());
  return values;
}

/// [low, high]; null is an open end.
inline ReportInterval interval_at(const Json& object, const std::string& key) {
  constexpr double open = std::numeric_limits<double>::infinity();
  const auto found = object.find(key);
  if (found == object.end() || !found->is_array()) return {};
  return {found->at(0).is_number() ? found->at(0).get<double>() : -open,
          found->at(1).is_number() ? found->at(1).get<double>() : open};
}

}  // namespace tribotrack::apps
