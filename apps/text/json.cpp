#include "apps/text/json.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <string_view>

#include "apps/program/errors.h"
#include "apps/text/strict_toml.h"

namespace tribotrack::apps {

namespace {

[[noreturn]] void refuse(const std::string& place, std::string_view what) {
  throw InvalidInput(fmt::format(
      "{}: is no JSON: {}; correct it, or make the file anew with the command that wrote it", place, what));
}

/// Of "[json.exception.parse_error.101] parse error at line 2, column 8: syntax error ...".
[[noreturn]] void refuse_as(std::string_view said, const std::string& name) {
  constexpr std::size_t kLongest = 200;  // it repeats what was read last
  int line = 0, column = 0;
  const auto at = std::min(said.find("at line "), said.size());
  if (std::sscanf(said.data() + at, "at line %d, column %d", &line, &column) != 2)
    refuse(name, said.substr(said.find(' ') + 1, kLongest));
  refuse(fmt::format("{}:{}:{}", name, line, column), said.substr(said.find(": ", at) + 2, kLongest));
}

/// Values that nest too deeply would fill the stack where they are copied; each name of an object is
/// compared with all others.
Json parse_json(std::string_view text, const std::string& name) {
  constexpr int kDeepest = 64, kMostNames = 10000;
  std::array<int, kDeepest + 1> names{};  // by depth, so far
  const auto require_flat = [&](int depth, Json::parse_event_t event, const Json&) {
    if (depth > kDeepest) refuse(name, fmt::format("it nests deeper than {} levels", kDeepest));
    if (event == Json::parse_event_t::object_start) names.at(static_cast<std::size_t>(depth)) = 0;
    if (event == Json::parse_event_t::key && ++names.at(static_cast<std::size_t>(depth) - 1) > kMostNames)
      refuse(name, fmt::format("an object holds more than {} names", kMostNames));
    return true;
  };
  try {
    return Json::parse(text, require_flat);
  } catch (const Json::exception& error) {
    refuse_as(error.what(), name);
  }
}

}  // namespace

std::string text_of(const Json& json) {
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

Json read_json(const std::filesystem::path& path) {
  return parse_json(read_text(path), path.string());
}

}  // namespace tribotrack::apps
