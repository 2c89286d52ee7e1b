// Values out of result files: required ones, whose absence is an error that names the key, and optional ones,
// whose absence is no value, an empty text, an empty list.
#pragma once

#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "apps/program/errors.h"
#include "apps/report/data/data.h"
#include "apps/text/json.h"

namespace tribotrack::apps {

/// A key that is missing or holds something else than it should. what() names the key, not the file.
class WrongContent : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A place in a file: "parameters.mu1" and what stands there.
struct JsonPlace {
  const Json& value;
  std::string path;

  /// Throws WrongContent where there is no such key.
  JsonPlace at(const std::string& key) const;
  JsonPlace at(std::size_t index) const;
  // Each throws WrongContent where the value is of another kind.
  double number() const;
  double number_or_null() const;  ///< NaN for null
  double sd_or_null() const;      ///< the same, and not below 0
  int integer() const;
  bool boolean() const;
  std::string text() const;
  const JsonPlace& object() const;
  const JsonPlace& list() const;    ///< may be empty
  ReportInterval interval() const;  ///< [low, high]; null is an open end
  [[noreturn]] void refuse(const std::string& expected) const;
};

/// Runs `read`; what it misses becomes an InvalidInput that names the file, too.
template <class Read>
void reading(const std::filesystem::path& file, const Read& read) {
  const auto refuse = [&](const std::string& why) {
    throw InvalidInput(file.string() + ": " + why + "; it is not what `tribotrack run` writes: run it again");
  };
  try {
    read();
  } catch (const WrongContent& error) {
    refuse(error.what());
  } catch (const Json::exception& error) {
    refuse(error.what());
  }
}

/// NaN where there is no number.
inline double number_at(const Json& object, const std::string& key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_number() ? found->get<double>() : no_value;
}

inline std::string text_at(const Json& object, const std::string& key) {
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
    for (const Json& item : *found)
      if (item.is_string()) values.push_back(item.get<std::string>());
  return values;
}

/// [low, high]; null is an open end; no interval where the key is absent.
inline ReportInterval interval_at(const Json& object, const std::string& key) {
  const auto found = object.find(key);
  return found == object.end() ? ReportInterval{} : JsonPlace{*found, key}.interval();
}

}  // namespace tribotrack::apps
