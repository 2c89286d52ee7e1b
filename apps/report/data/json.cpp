#include "apps/report/data/json.h"

#include <fmt/format.h>

namespace tribotrack::apps {

JsonPlace JsonPlace::at(const std::string& key) const {
  object();
  const std::string place = path.empty() ? key : path + "." + key;
  const auto found = value.find(key);
  if (found == value.end()) throw WrongContent(fmt::format("`{}` is missing", place));
  return {*found, place};
}

JsonPlace JsonPlace::at(std::size_t index) const {
  const std::string place = fmt::format("{}[{}]", path, index);
  if (!value.is_array() || index >= value.size()) throw WrongContent(fmt::format("`{}` is missing", place));
  return {value[index], place};
}

double JsonPlace::number() const {
  if (!value.is_number()) refuse("a number");
  return value.get<double>();
}

double JsonPlace::number_or_null() const {
  return value.is_null() ? no_value : number();
}

double JsonPlace::sd_or_null() const {
  const double sd = number_or_null();
  if (sd < 0) refuse("0 or more");
  return sd;
}

int JsonPlace::integer() const {
  if (!value.is_number_integer()) refuse("a whole number");
  return value.get<int>();
}

bool JsonPlace::boolean() const {
  if (!value.is_boolean()) refuse("true or false");
  return value.get<bool>();
}

std::string JsonPlace::text() const {
  if (!value.is_string()) refuse("a text");
  return value.get<std::string>();
}

const JsonPlace& JsonPlace::object() const {
  if (!value.is_object()) refuse("an object");
  return *this;
}

const JsonPlace& JsonPlace::list() const {
  if (!value.is_array()) refuse("a list");
  return *this;
}

ReportInterval JsonPlace::interval() const {
  constexpr double open = std::numeric_limits<double>::infinity();
  if (!value.is_array() || value.size() != 2) refuse("a list of two numbers");
  const auto end = [&](std::size_t k, double if_open) {
    return value[k].is_null() ? if_open : at(k).number();
  };
  const ReportInterval interval{end(0, -open), end(1, open)};
  if (interval.low > interval.high) refuse("an interval, the low end first");
  return interval;
}

void JsonPlace::refuse(const std::string& expected) const {
  std::string seen = value.dump(-1, ' ', false, Json::error_handler_t::replace);
  if (seen.size() > 40) seen = fmt::format("a value of type {}", value.type_name());
  throw WrongContent(path.empty() ? fmt::format("must hold {}, not {}", expected, seen)
                                  : fmt::format("`{}` must be {}, not {}", path, expected, seen));
}

}  // namespace tribotrack::apps
