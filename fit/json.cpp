#include "fit/json.h"

#include <fmt/format.h>

#include <limits>

namespace tribotrack::fit {

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

std::optional<JsonPlace> JsonPlace::find(const std::string& key) const {
  object();
  const auto found = value.find(key);
  if (found == value.end() || found->is_null()) return std::nullopt;
  return JsonPlace{*found, path.empty() ? key : path + "." + key};
}

double JsonPlace::number() const {
  if (!value.is_number()) refuse("a number");
  return value.get<double>();
}

double JsonPlace::number_or_null() const {
  return value.is_null() ? std::numeric_limits<double>::quiet_NaN() : number();
}

std::int64_t JsonPlace::whole() const {
  constexpr std::uint64_t most = std::numeric_limits<std::int64_t>::max();
  constexpr double exact = 0x1p53;
  if (value.is_number_unsigned() && value.get<std::uint64_t>() > most) refuse("a whole number that fits");
  if (value.is_number_integer()) return value.get<std::int64_t>();
  if (!value.is_number()) refuse("a whole number");
  const double real = value.get<double>();
  if (std::abs(real) > exact || real != std::floor(real)) refuse("a whole number");
  return static_cast<std::int64_t>(real);
}

int JsonPlace::integer() const {
  const std::int64_t number = whole();
  if (number < std::numeric_limits<int>::min() || number > std::numeric_limits<int>::max())
    refuse("a whole number below 2147483648");
  return static_cast<int>(number);
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

std::vector<JsonPlace> JsonPlace::items() const {
  list();
  std::vector<JsonPlace> places;
  for (std::size_t k = 0; k < value.size(); ++k) places.push_back(at(k));
  return places;
}

std::vector<JsonPlace> JsonPlace::items(const std::string& key) const {
  const auto found = find(key);
  return found ? found->items() : std::vector<JsonPlace>();
}

std::vector<std::string> JsonPlace::texts(const std::string& key) const {
  std::vector<std::string> texts;
  for (const JsonPlace& item : items(key)) texts.push_back(item.text());
  return texts;
}

void JsonPlace::refuse(const std::string& expected) const {
  std::string seen = value.dump(-1, ' ', false, Json::error_handler_t::replace);
  if (seen.size() > 40) seen = fmt::format("a value of type {}", value.type_name());
  throw WrongContent(path.empty() ? fmt::format("must hold {}, not {}", expected, seen)
                                  : fmt::format("`{}` must be {}, not {}", path, expected, seen));
}

}  // namespace tribotrack::fit
