// JSON as this program reads and writes it.
#pragma once

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

namespace tribotrack::apps {

/// Keys keep the order they were written in: files for people as well.
using Json = nlohmann::ordered_json;

/// Text of a JSON value, two spaces of indent, final newline. NaN becomes null.
std::string text_of(const Json& json);

/// Reads a JSON file. Throws InvalidInput.
Json read_json(const std::filesystem::path& path);

/// null for what is not finite.
inline Json finite_json(double value) {
  return std::isfinite(value) ? Json(value) : Json();
}

/// null where there is no value.
template <class T>
Json optional_json(const std::optional<T>& value) {
  return value ? Json(*value) : Json();
}

}  // namespace tribotrack::apps
