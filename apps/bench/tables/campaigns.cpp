#include "apps/bench/tables/campaigns.h"

#include <algorithm>
#include <array>
#include <string_view>

#include "apps/bench/tables/columns.h"
#include "apps/program/errors.h"
#include "apps/text/csv_table.h"

namespace tribotrack::bench {

namespace {

enum class Said { failed, not_usable, weak, identifiable };
constexpr std::array kSaid{Said::failed, Said::not_usable, Said::weak, Said::identifiable};

const char* to_string(Said said) {
  switch (said) {
    case Said::failed:
      return "failed";
    case Said::not_usable:
      return "not usable";
    case Said::weak:
      return "weak";
    case Said::identifiable:
      return "identifiable";
  }
  return "";
}

Said said_of(const JudgedParameter& one) {
  if (!one.fitted) return Said::failed;
  if (!one.usable) return Said::not_usable;
  return one.weak ? Said::weak : Said::identifiable;
}

constexpr std::array<bool, 2> kYesOrNo{true, false};

/// The value whose name stands in the cell.
template <class Values, class Name>
auto named(const apps::CsvTable& table, std::string_view cell, const Values& values, const Name& name) {
  const auto found = std::ranges::find_if(values, [&](const auto value) { return name(value) == cell; });
  if (found == values.end()) table.fail(cell, fmt::format("\"{}\" is no word of this column", cell));
  return *found;
}

const Columns<JudgedParameter>& columns() {
  using Row = JudgedParameter;
  static const Columns<Row> all{
      {"design", [](const Row& r) { return std::string(to_string(r.design)); }},
      {"noise", [](const Row& r) { return to_string(r.level); }},
      {"campaign", &Row::campaign},
      {"parameter", bare(&Row::parameter)},
      {"fit", [](const Row& r) { return to_string(said_of(r)); }},
      {"open", [](const Row& r) { return r.interval.open; }},
      {"holds", [](const Row& r) { return r.interval.holds; }},
      {"score", [](const Row& r) { return Exact{r.interval.score}; }},
  };
  return all;
}
constexpr std::size_t kColumns = 8;

}  // namespace

std::string csv_of(const std::vector<JudgedParameter>& judged) {
  return columns().csv(judged);
}

std::vector<JudgedParameter> read_campaigns(const std::filesystem::path& path, std::string csv) {
  const std::string header = columns().csv({});
  if (!csv.starts_with(header))
    throw apps::InvalidInput(
        fmt::format("{}:1: is not a table of simulated campaigns, which begins with \"{}\"", path.string(),
                    header.substr(0, header.size() - 1)));
  apps::CsvTable table(path, std::move(csv));
  table.next();
  std::vector<JudgedParameter> judged;
  while (table.next()) {
    const auto& cells = table.cells();
    if (cells.size() != kColumns) table.fail(fmt::format("{} cells instead of {}", cells.size(), kColumns));
    JudgedParameter one;
    one.design = named(table, cells[0], kDesigns, [](Design value) { return bench::to_string(value); });
    one.level =
        named(table, cells[1], kNoiseLevels, [](NoiseLevel value) { return bench::to_string(value); });
    one.campaign = static_cast<int>(table.number(cells[2]));
    one.parameter = cells[3];
    const Said said = named(table, cells[4], kSaid, [](Said value) { return to_string(value); });
    one.fitted = said != Said::failed;
    one.weak = said == Said::weak;
    one.usable = one.weak || said == Said::identifiable;
    one.interval.open = named(table, cells[5], kYesOrNo, yes);
    one.interval.holds = named(table, cells[6], kYesOrNo, yes);
    one.interval.score = table.number(cells[7]);
    judged.push_back(one);
  }
  std::ranges::stable_sort(judged, std::less<>());
  return judged;
}

}  // namespace tribotrack::bench
