#include "apps/files/parts/work_part.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <map>

#include "apps/files/meta_file.h"
#include "apps/json/json_place.h"
#include "apps/program/errors.h"
#include "apps/text/strict_toml.h"

namespace tribotrack::apps {

namespace fs = std::filesystem;

namespace {

fs::path meta_of(const fs::path& part) {
  return part.string() + ".meta.json";
}

/// One part's table and what its meta file says.
struct PartTable {
  fs::path path;
  std::string text;
  Json meta;
  WorkPart part;
};

[[noreturn]] void refuse_no_part(const fs::path& path, std::string_view work) {
  throw InvalidInput(
      fmt::format("{}: is not the meta file of a part of a {}; give tables that `tribotrack "
                  "{} --part K/N` wrote, their meta files beside them",
                  meta_of(path).string(), work, work));
}

/// `work` is the command, or begins with it.
bool made_by(const Json& meta, std::string_view work) {
  const auto command = meta.find("command");
  return command != meta.end() && command->is_string() &&
         work.starts_with(command->get_ref<const std::string&>());
}

PartTable read_part(const fs::path& path, std::string_view work) {
  PartTable table{path, read_text(path), read_json(meta_of(path)), {}};
  const auto configuration = table.meta.find("configuration");
  if (configuration == table.meta.end() || !configuration->is_object() || !configuration->contains("part") ||
      !table.meta.contains("inputs") || !made_by(table.meta, work))
    refuse_no_part(path, work);
  require_known_schema(table.meta, meta_of(path));
  std::size_t rows = 0;
  try {
    const JsonPlace part = JsonPlace{table.meta, ""}.at("configuration").at("part");
    table.part = work_part(fmt::format("{}/{}", part.at("number").integer(), part.at("of").integer()));
    rows = static_cast<std::size_t>(std::max(0, part.at("rows").integer()));
  } catch (const std::exception&) {
    refuse_no_part(path, work);
  }
  const auto lines = static_cast<std::size_t>(std::ranges::count(table.text, '\n'));
  if (lines != rows + 1)
    throw InvalidInput(fmt::format("{}: holds {} lines where its meta file says {} rows; make the part again",
                                   path.string(), lines, rows));
  table.meta["configuration"].erase("part");
  return table;
}

/// What all parts have in common: everything but where the input lay.
Json common(Json meta) {
  for (Json& input : meta["inputs"]) input.erase("path");
  return meta;
}

}  // namespace

JoinedTable joined_tables(const std::vector<fs::path>& parts, std::string_view work) {
  std::vector<PartTable> tables;
  for (const fs::path& path : parts) tables.push_back(read_part(path, work));
  const PartTable& first = tables.front();
  std::map<std::size_t, const PartTable*> by_number;
  for (const PartTable& table : tables) {
    if (table.part.of != first.part.of || common(table.meta) != common(first.meta))
      throw InvalidInput(fmt::format("{}: is a part of another {} than {}: its {} differ",
                                     table.path.string(), work, first.path.string(),
                                     table.part.of != first.part.of ? "number of parts" : "meta files"));
    if (const auto [other, is_new] = by_number.emplace(table.part.number, &table); !is_new)
      throw InvalidInput(fmt::format("{}: is part {} of {}, as {} is; give each part once",
                                     table.path.string(), table.part.number, table.part.of,
                                     other->second->path.string()));
  }
  for (std::size_t number = 1; number <= first.part.of; ++number)
    if (!by_number.contains(number))
      throw InvalidInput(fmt::format("{}: of its {} part {} of {} is not given: make it with --part {}/{}",
                                     first.path.string(), work, number, first.part.of, number,
                                     first.part.of));
  JoinedTable whole;
  whole.text = first.text.substr(0, first.text.find('\n') + 1);
  const std::size_t header = whole.text.size();
  for (const auto& [number, table] : by_number) {
    if (table->text.compare(0, header, whole.text, 0, header) != 0)
      throw InvalidInput(
          fmt::format("{}: has another header than {}", table->path.string(), first.path.string()));
    whole.text.append(table->text, header);
  }
  whole.meta = by_number.begin()->second->meta;
  return whole;
}

WorkPart work_part(const std::string& text) {
  WorkPart part;
  const char* const end = text.data() + text.size();
  const auto number = std::from_chars(text.data(), end, part.number);
  const bool slash = number.ec == std::errc() && number.ptr != end && *number.ptr == '/';
  const auto of = slash ? std::from_chars(number.ptr + 1, end, part.of) : number;
  if (!slash || of.ec != std::errc() || of.ptr != end || part.number < 1 || part.number > part.of ||
      static_cast<double>(part.of) > kMostParts)
    throw UsageError(fmt::format("--part must read K/N, part K of N, such as 1/8, not \"{}\"", text));
  return part;
}

Json json_of(const WorkPart& part, std::size_t rows) {
  return {{"number", part.number}, {"of", part.of}, {"rows", rows}};
}

}  // namespace tribotrack::apps
