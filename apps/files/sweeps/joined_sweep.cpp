#include "apps/files/sweeps/joined_sweep.h"

#include <fmt/format.h>

#include "apps/program/errors.h"
#include "apps/text/strict_toml.h"

namespace tribotrack::apps {

namespace fs = std::filesystem;

namespace {

JoinedTable joined_objects(const std::vector<fs::path>& parts) {
  Json whole;
  for (const fs::path& path : parts) {
    const Json part = read_json(path);
    for (const auto& [name, column] : part.items()) {
      if (!column.is_array() || (path != parts.front() && !whole.contains(name)))
        throw InvalidInput(fmt::format("{}: `{}` is no column of the sweep in {}", path.string(), name,
                                       parts.front().string()));
      for (const Json& value : column) whole[name].push_back(value);
      if (path == parts.front() && !whole.contains(name)) whole[name] = Json::array();
    }
  }
  return {text_of(whole), {}};
}

}  // namespace

JoinedTable joined_sweep(const std::vector<fs::path>& parts) {
  std::vector<fs::path> tables;
  for (const fs::path& path : parts)
    if (!read_text(path).starts_with('{')) tables.push_back(path);
  if (tables.size() == parts.size()) return joined_tables(parts, "sweep");
  if (!tables.empty())
    throw InvalidInput(fmt::format("{}: is a table, but others of the parts are JSON; give parts of one kind",
                                   tables.front().string()));
  return joined_objects(parts);
}

}  // namespace tribotrack::apps
