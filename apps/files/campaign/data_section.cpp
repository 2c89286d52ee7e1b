#include "apps/files/campaign/data_section.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <numbers>
#include <optional>
#include <utility>

#include "apps/files/campaign/alpha_v_table.h"
#include "apps/files/campaign/campaign.h"
#include "apps/files/campaign/keys.h"
#include "apps/files/campaign/sections.h"
#include "apps/program/errors.h"
#include "apps/text/csv_table.h"
#include "fit/pooling.h"

namespace tribotrack::apps {

namespace fs = std::filesystem;

namespace {

/// Two numbers of a spreadsheet that mean the same, its rounding included.
bool same(double a, double b) {
  constexpr double kRounding = 1e-9;
  return std::abs(a - b) <= kRounding * std::max({1.0, std::abs(a), std::abs(b)});
}
bool same(const std::optional<double>& a, const std::optional<double>& b) {
  return a.has_value() == b.has_value() && (!a || same(*a, *b));
}
bool same_angle(double a, double b) {
  return same(std::remainder(a - b, 2 * std::numbers::pi), 0);
}

bool same_point(const CampaignRun& a, const CampaignRun& b) {
  return same_angle(a.phi, b.phi) && same(a.dtau, b.dtau) && same(a.amplitude, b.amplitude) &&
         same(a.angular_frequency, b.angular_frequency) && same(a.start_phase, b.start_phase) &&
         a.cycles == b.cycles;
}

/// The points seen so far, by where they lie in phi and dtau: whether a line repeats one of many is known
/// without looking at them all.
class PointsByPlace {
 public:
  void add(const CampaignRun& line, std::size_t point) { cells_[cell_of(line)].push_back(point); }
  /// The first of those that lie near, in the order of their numbers, for which `wanted` holds.
  template <class Wanted>
  std::optional<std::size_t> find(const CampaignRun& line, const Wanted& wanted) const {
    std::optional<std::size_t> first;
    const auto [phi, dtau] = cell_of(line);
    for (long long i = -1; i <= 1; ++i)
      for (long long j = -1; j <= 1; ++j)
        if (const auto cell = cells_.find({(phi + i + kTurn) % kTurn, dtau + j}); cell != cells_.end())
          for (const std::size_t point : cell->second)
            if ((!first || point < *first) && wanted(point)) first = point;
    return first;
  }

 private:
  using Cell = std::pair<long long, long long>;
  // Of 1e-5 rad: numbers that mean the same lie in one cell or in neighbouring ones.
  static constexpr long long kTurn = 628'318;  ///< cells of a turn
  static Cell cell_of(const CampaignRun& line) {
    const double turns = line.phi / (2 * std::numbers::pi);
    return {static_cast<long long>((turns - std::floor(turns)) * kTurn) % kTurn,
            static_cast<long long>(std::floor(line.dtau * (kTurn / (2 * std::numbers::pi))))};
  }
  std::map<Cell, std::vector<std::size_t>> cells_;
};

/// Where no sd is known: of the first such line.
[[noreturn]] void refuse_without_sd(const CampaignRun& line, const fit::PooledPoints& pooled) {
  const bool alpha = !line.alpha_sd, v = !line.v_sd;
  throw InvalidInput(fmt::format(
      "{}: nothing says how good its {} {}: {}; fill in {}, or give the sd of all lines once, [data] {}",
      line.place,
      alpha && v ? "alpha and v"
      : alpha    ? "alpha"
                 : "v",
      alpha && v ? "are" : "is",
      pooled.along.dof + pooled.across.dof == 0 ? "it has no sd and no point of the table is measured twice"
                                                : "it has no sd and the repeats do not differ",
      alpha && v ? "alpha_sd_deg and v_sd_mm_s"
      : alpha    ? "alpha_sd_deg"
                 : "v_sd_mm_s",
      alpha && v ? "alpha_sd_rad = \"2deg\", v_sd_mm_s = 0.1"
      : alpha    ? "alpha_sd_rad = \"2deg\""
                 : "v_sd_mm_s = 0.1"));
}

using Points = std::vector<std::vector<std::size_t>>;  ///< the lines of each

/// The lines of all tables.
std::vector<CampaignRun> lines_of(Campaign& campaign) {
  std::vector<CampaignRun> lines;
  for (const fs::path& path : campaign.data.tables) {
    AlphaVTable table = read_alpha_v_table(path, campaign.fit);
    campaign.table_inputs.push_back(table.input);
    std::ranges::move(table.notes, std::back_inserter(campaign.notes));
    std::ranges::move(table.runs, std::back_inserter(lines));
  }
  for (CampaignRun& line : lines) {
    if (!line.alpha_sd) line.alpha_sd = campaign.data.alpha_sd;
    if (!line.v_sd) line.v_sd = campaign.data.v_sd;
  }
  return lines;
}

Points points_of(const std::vector<CampaignRun>& lines) {
  Points points;
  PointsByPlace known;
  for (std::size_t k = 0; k < lines.size(); ++k) {
    const auto repeated = known.find(
        lines[k], [&](std::size_t point) { return same_point(lines[points[point].front()], lines[k]); });
    if (!repeated) {
      known.add(lines[k], points.size());
      points.emplace_back();
    }
    points[repeated.value_or(points.size() - 1)].push_back(k);
  }
  return points;
}

fit::PooledPoints pooled_points(const std::vector<CampaignRun>& lines, const Points& points) {
  std::vector<fit::PointMeasurement> measurements(lines.size());
  for (std::size_t p = 0; p < points.size(); ++p)
    for (const std::size_t k : points[p])
      measurements[k] = {
          p, {{*lines[k].alpha, lines[k].alpha_sd.value_or(0)}, {*lines[k].v, lines[k].v_sd.value_or(0)}}};
  return fit::pool_points(measurements);
}

/// "alpha_v:7" by the table and its line, for "folder/alpha_v.csv:7".
std::string name_by_place(const fs::path& place) {
  const std::string line = place.extension().string();
  return place.stem().string() + line.substr(std::min(line.find(':'), line.size()));
}

/// The run of a point whose values are pooled.
CampaignRun run_of(const std::vector<CampaignRun>& lines, const std::vector<std::size_t>& members,
                   const fit::AlphaV& value, const fit::PooledPoints& pooled) {
  for (const std::size_t k : members)
    if ((!lines[k].alpha_sd && !(value.alpha.sd > 0)) || (!lines[k].v_sd && !(value.velocity.sd > 0)))
      refuse_without_sd(lines[k], pooled);
  CampaignRun run = lines[members.front()];
  if (run.name.empty()) run.name = name_by_place(run.place);
  run.alpha = value.alpha.value;
  run.alpha_sd = value.alpha.sd;
  run.v = value.velocity.value;
  run.v_sd = value.velocity.sd;
  if (members.size() > 1)
    for (const std::size_t k : members) run.pooled_from.push_back(lines[k].place);
  return run;
}

/// What was pooled, and where sds came from.
void note(Campaign& campaign, std::size_t lines, std::size_t points, const fit::PooledPoints& pooled) {
  if (lines > points)
    campaign.notes.push_back(fmt::format(
        "{} lines of tables are {} points: repeats of one point are pooled into their mean", lines, points));
  std::vector<std::string> sds;
  if (const fit::RepeatScatter& alpha = pooled.across; alpha.sd > 0)
    sds.push_back(alpha.relative ? fmt::format("alpha {:.2g} rad ({:.2g} deg)", alpha.sd,
                                               alpha.sd * 180 / std::numbers::pi)
                                 : fmt::format("alpha {:.2g} mm/s over v", alpha.sd * 1e3));
  if (const fit::RepeatScatter& v = pooled.along; v.sd > 0)
    sds.push_back(v.relative ? fmt::format("v {:.2g} %", v.sd * 100)
                             : fmt::format("v {:.2g} mm/s", v.sd * 1e3));
  if (!sds.empty()) {
    const std::size_t dof = std::max(pooled.along.dof, pooled.across.dof);
    campaign.notes.push_back(
        fmt::format("lines without an sd have that of the scatter between repeats: of one measurement {} "
                    "({} degree{} of "
                    "freedom), widened {:.2f} times, so that 95 % intervals are Student's",
                    fmt::join(sds, ", "), dof, dof == 1 ? "" : "s", pooled.widened));
  }
  if (pooled.scattered > 1)
    campaign.warnings.push_back(fmt::format(
        "repeats in the tables scatter {:.2g} times as much as their sds say (chi2 {:.3g} at {} degrees of "
        "freedom): the sds of all their lines are widened by that",
        pooled.scattered, pooled.chi2, pooled.chi2_dof));
}

/// A column of a table of runs: the key that it gives, and the factor from its unit to the key's.
struct RunColumn {
  const KeyFacts* key = nullptr;
  std::string name;   ///< the key's, or another of the same quantity
  double factor = 1;  ///< 0: the column says no unit
  bool degrees = false;
};

/// Nothing where no key of a run is of this quantity and dimension.
RunColumn run_column(Heading heading) {
  for (const char* word : {"file", "filename", "file_name", "recording", "movie"})
    if (heading.quantity == word) heading.quantity = "video";
  for (const KeyFacts& key : run_keys()) {
    std::vector<OtherName> names = other_names(key.quantity());
    names.insert(names.begin(), {key.quantity()});
    for (const OtherName& name : names) {
      const Heading own = heading_of(name.name);
      if (own.quantity != heading.quantity || key.kind.is_sd() != heading.sd) continue;
      const RunColumn column{&key, name.name + (heading.sd ? "_sd" : ""), 1, heading.unit == "deg"};
      if (heading.unit == own.unit) return column;
      if (heading.unit.empty()) return {column.key, column.name, 0};
      for (int k = 0; k <= static_cast<int>(Dimension::voltage); ++k) {
        const auto from = si_per(heading.unit, static_cast<Dimension>(k)),
                   to = si_per(own.unit, static_cast<Dimension>(k));
        if (from && to) return {column.key, column.name, *from / *to, column.degrees};
      }
    }
  }
  return {};
}

/// An angle with its unit in the cell, as campaigns write it.
std::string campaign_angle(std::string text) {
  for (const auto& [written, meant] : {std::pair("\u00b0", "deg"), {"degrees", "deg"}, {"rad", ""}})
    if (const std::string_view end = written; text.ends_with(end))
      return text.substr(0, text.find_last_not_of(' ', text.size() - end.size() - 1) + 1) + meant;
  return text;
}

Json value_in(const CsvTable& table, std::string_view cell, const RunColumn& column) {
  switch (column.key->kind.form) {
    case Kind::word:
    case Kind::text:
    case Kind::file:
    case Kind::text_or_texts:
      return std::string(cell);
    case Kind::whole: {
      const double number = table.number(cell);
      if (number != std::floor(number) || std::abs(number) > 1e9)
        table.fail(cell, fmt::format("`{}` is no whole number", cell));
      return static_cast<std::int64_t>(number);
    }
    default:
      break;
  }
  const auto number = table.number_in(cell);
  if (number && column.factor == 0)
    table.fail(cell, fmt::format("`{}` has no unit: name its column {}, or another unit", cell, column.name));
  const bool angle = column.key->quantity().ends_with("_rad");
  if (number && column.degrees) return fmt::format("{}deg", *number);
  if (!number && angle) return campaign_angle(table.with_point(cell));  // "pi/3"
  return column.factor * table.number(cell);
}

}  // namespace

RunList read_run_list(const fs::path& path, std::string text) {
  CsvTable table(path, std::move(text), [](const Cells& cells) {
    return static_cast<int>(std::ranges::count_if(
        cells, [](std::string_view cell) { return run_column(heading_of(cell)).key != nullptr; }));
  });
  if (table.header().empty())
    throw InvalidInput(
        fmt::format("{}: no line names its columns: {}; a table of runs has the columns video (or track), "
                    "phi_deg and dtau_deg",
                    path.string(), table.holds()));
  RunList list;
  std::vector<RunColumn> columns;
  for (std::size_t k = 0; k < table.header().size(); ++k) {
    columns.push_back(run_column(table.heading(k)));
    if (columns.back().key == nullptr && !table.header()[k].empty())
      list.unused.emplace_back(table.header()[k]);
  }
  while (table.next()) {
    Json run = Json::object();
    for (std::size_t k = 0; k < std::min(table.filled(), columns.size()); ++k) {
      const std::string_view cell = table.cells()[k];
      if (columns[k].key != nullptr && !CsvTable::is_none(cell))
        run[columns[k].name] = value_in(table, cell, columns[k]);
    }
    list.lines.push_back({table.place(), std::move(run)});
  }
  return list;
}

void add_listed_runs(Campaign& campaign) {
  if (!campaign.data.runs) return;
  const fs::path& path = *campaign.data.runs;
  std::string text = read_text(path);
  campaign.table_inputs.push_back(hashed_input(path, text));
  const RunList list = read_run_list(path, std::move(text));
  for (const RunList::Line& line : list.lines) {
    StrictTable one = StrictTable::of(line.keys, line.place);
    campaign.runs.push_back(read_run(one, campaign));
  }
  if (!list.unused.empty())
    campaign.notes.push_back(fmt::format("{}: not used: {}", path.string(), fmt::join(list.unused, ", ")));
}

void read_tables(StrictTable& table, DataSection& data, const fs::path& folder) {
  std::vector<std::string> names;
  if (table.is_list("table"))
    names = table.texts("table").value();
  else if (const auto one = table.text("table"))
    names = {*one};
  for (const std::string& name : names) {
    const fs::path path = folder / name;
    if (std::ranges::count(data.tables, path) > 0)
      table.fail("table", fmt::format("names \"{}\" twice", name));
    data.tables.push_back(path);
  }
}

Json written_tables(const DataSection& data) {
  Json names = Json::array();
  for (const fs::path& table : data.tables) names.push_back(table.filename().string());
  return names;
}

DataSection read_data(StrictTable& table, const fs::path& folder) {
  DataSection data;
  read_keys(table, data_keys(), data, folder);
  if (data.alpha_sd && !(*data.alpha_sd > 0)) table.fail("alpha_sd_rad", "must be greater than 0");
  table.finish();
  return data;
}

void add_table_runs(Campaign& campaign) {
  if (campaign.data.tables.empty()) return;
  const std::vector<CampaignRun> lines = lines_of(campaign);
  const Points points = points_of(lines);
  const fit::PooledPoints pooled = pooled_points(lines, points);
  for (std::size_t p = 0; p < points.size(); ++p)
    campaign.runs.push_back(run_of(lines, points[p], pooled.points[p], pooled));
  note(campaign, lines.size(), points.size(), pooled);
}

}  // namespace tribotrack::apps
