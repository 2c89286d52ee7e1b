// The file beside each result that says how it came about.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "vision/time_base.h"
#include "vision/tracker.h"

namespace tribotrack::apps {

/// Keys keep the order they were written in: files for people as well.
using Json = nlohmann::ordered_json;

/// XXH3-128 of a file, as hex; of a folder or a printf pattern, of its pictures in order. Throws
/// InvalidInput.
std::string hash_of_input(const std::filesystem::path& path);

/// Of the result files; stands in their meta files.
inline constexpr int kSchemaVersion = 1;

/// X.meta.json for result X: program and schema version, input hashes, effective configuration, and whatever
/// a command adds (time base, plan with predicted savings). Nothing volatile: same inputs, same bytes.
struct MetaFile {
  std::string command;
  std::vector<std::filesystem::path> inputs;
  Json configuration = Json::object();
  Json more = Json::object();
  Json json() const;
  void write_beside(const std::filesystem::path& result) const;
};

Json json_of(const vision::TimeBase& time_base);
Json json_of(const std::vector<vision::PlanStage>& plan);

/// Text of a JSON value, two spaces of indent, final newline. NaN becomes null.
std::string text_of(const Json& json);

/// Reads a JSON file. Throws InvalidInput.
Json read_json(const std::filesystem::path& path);

}  // namespace tribotrack::apps
