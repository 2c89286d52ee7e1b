// Work in parts, each done by a job of its own, and the whole from their tables.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "apps/text/json.h"

namespace tribotrack::apps {

/// Part `number` of `of` parts.
struct WorkPart {
  std::size_t number = 1, of = 1;
  /// Of a row of things: neighbours, as evenly many in each part as can be.
  std::size_t begin(std::size_t count) const { return place(number - 1, count); }
  std::size_t end(std::size_t count) const { return place(number, count); }

 private:
  std::size_t place(std::size_t parts, std::size_t count) const {
    // Of at most 1e8 things and parts: the product fits.
    return parts * count / of;
  }
};
inline constexpr double kMostParts = 1e8;

/// "3/8". Throws UsageError.
WorkPart work_part(const std::string& text);

/// What a part's meta file says of it, under "part" in its configuration.
Json json_of(const WorkPart& part, std::size_t rows);

struct JoinedTable {
  std::string text;  ///< the rows of the parts, in the order of their numbers, below their common header
  Json meta;         ///< what the meta files of the parts have in common
};

/// Tables may come in any order, their meta files beside them: all parts of one `work` ("sweep", a command),
/// each once. Throws InvalidInput naming the file.
JoinedTable joined_tables(const std::vector<std::filesystem::path>& parts, std::string_view work);

}  // namespace tribotrack::apps
