// JSON as this program reads and writes it.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "fit/json.h"

namespace tribotrack::apps {

using fit::finite_json;
using fit::Json;
using fit::JsonPlace;
using fit::WrongContent;

/// Text of a JSON value, two spaces of indent, final newline. NaN becomes null.
std::string text_of(const Json& json);

/// Reads a JSON file. Throws InvalidInput.
Json read_json(const std::filesystem::path& path);

/// null where there is no value.
template <class T>
Json optional_json(const std::optional<T>& value) {
  return value ? Json(*value) : Json();
}

}  // namespace tribotrack::apps
