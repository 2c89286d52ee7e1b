// The file beside each result that records how it was made.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "apps/text/input_file.h"
#include "apps/text/json.h"
#include "vision/picture.h"
#include "vision/time_base.h"
#include "vision/tracker.h"

namespace tribotrack::apps {

/// Of the result files; stands in their meta files.
inline constexpr int kSchemaVersion = 1;

/// X.meta.json for result X: program and schema version, inputs with their hashes, effective configuration,
/// and whatever a command adds (time base, plan). Nothing volatile: same inputs, same bytes.
struct MetaFile {
  std::string command;
  std::vector<Input> inputs;
  Json configuration = Json::object();
  Json more = Json::object();
  Json json() const;
  void write_beside(const std::filesystem::path& result) const;
};

/// Throws InvalidInput where a meta file was written by a newer version than this.
void require_known_schema(const Json& meta, const std::filesystem::path& file);

/// A result and its meta file; where `path` is the standard output, the result alone goes there.
void write_result(const std::filesystem::path& path, std::string_view text, const MetaFile& meta);

Json json_of(const vision::TimeBase& time_base);
Json json_of(const std::vector<vision::PlanStage>& plan);
Json json_of(const std::vector<vision::SlowPart>& slow);
Json json_of(const vision::Audit& audit);
Json json_of(const vision::CodedErrors& coded);

/// [x, y, radius]; null where there is none.
Json circle_json(const std::optional<vision::Circle>& circle);
Json rect_json(const std::optional<vision::Rect>& rect);

}  // namespace tribotrack::apps
