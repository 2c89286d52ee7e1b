#include "apps/files/campaign/data_section.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <utility>

#include "apps/files/campaign/campaign.h"
#include "apps/files/campaign/keys.h"
#include "apps/program/errors.h"
#include "apps/text/angle.h"
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

bool same_point(const CampaignRun& a, const CampaignRun& b) {
  return same(std::remainder(a.phi - b.phi, 2 * std::numbers::pi), 0) && same(a.dtau, b.dtau) &&
         same(a.amplitude, b.amplitude) && same(a.angular_frequency, b.angular_frequency) &&
         same(a.start_phase, b.start_phase) && a.cycles == b.cycles;
}

/// Where no sd is known: of the first such line.
[[noreturn]] void refuse_without_sd(const CampaignRun& line, const fit::PooledPoints& pooled) {
  throw InvalidInput(
      "{}: nothing says how good its {}: {}; fill in alpha_sd_deg and v_sd_mm_s, or give the sd of all lines "
      "once, [data] alpha_sd_rad = \"2deg\", v_sd_mm_s = 0.1",
      line.place,
      line.v_sd       ? "alpha is"
      : line.alpha_sd ? "v is"
                      : "alpha and v are",
      pooled.along.dof + pooled.across.dof == 0 ? "it has no sd and no point of the table is measured twice"
                                                : "it has no sd and the repeats do not differ");
}

using Points = std::vector<std::vector<std::size_t>>;  ///< the lines of each

Points points_of(const std::vector<CampaignRun>& lines) {
  Points points;
  for (std::size_t k = 0; k < lines.size(); ++k) {
    const auto repeated = std::ranges::find_if(
        points, [&](const auto& point) { return same_point(lines[point.front()], lines[k]); });
    if (repeated == points.end())
      points.push_back({k});
    else
      repeated->push_back(k);
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
        fmt::format("lines without an sd have that of the scatter between repeats: of one measurement {} ({} "
                    "degree{} of freedom), widened {:.2f} times, so that 95 % intervals are Student's",
                    fmt::join(sds, ", "), dof, dof == 1 ? "" : "s", pooled.widened));
  }
  if (pooled.scattered > 1)
    campaign.warnings.push_back(
        fmt::format("repeats in the tables scatter {:.2g} times as much as their sds say (chi2 {:.3g} at {} "
                    "degrees of freedom): the sds of all their lines are widened by that",
                    pooled.scattered, pooled.chi2, pooled.chi2_dof));
}

/// A column of a table of runs: the key that it gives, and the factors from its unit to the key's.
struct RunColumn {
  const KeyFacts* key = nullptr;
  std::string name;  ///< the key's, or another of the same quantity
  double factor = 1,
         to_named = 1;  ///< to the unit of `name`, 0: the column says none; from there to the key's
  bool degrees = false;
};

/// What people write for the quantity of a key.
const std::map<std::string, std::string, std::less<>> kAlsoCalled = {
    {"file", "video"},  {"filename", "video"}, {"file_name", "video"},     {"recording", "video"},
    {"movie", "video"}, {"d_tau", "dtau"},     {"delta_tau", "dtau"},      {"velocity", "v"},
    {"speed", "v"},     {"f", "frequency"},    {"w", "angular_frequency"}, {"run", "name"}};

/// Nothing where no key of a run, of these alone where there are any, is of this quantity and dimension.
RunColumn run_column(Heading heading, const std::vector<std::string>& only) {
  if (const auto known = kAlsoCalled.find(heading.quantity); known != kAlsoCalled.end())
    heading.quantity = known->second;
  for (const KeyFacts& key : run_keys()) {
    if (!only.empty() && std::ranges::count(only, key.quantity()) == 0) continue;
    std::vector<OtherName> names = other_names(key.quantity());
    names.insert(names.begin(), {key.quantity()});
    for (const OtherName& name : names) {
      const Heading own = heading_of(name.name);
      if (own.quantity != heading.quantity || (own.sd || key.kind.is_sd()) != heading.sd) continue;
      RunColumn column{&key, name.name + (key.kind.is_sd() ? "_sd" : ""), 1, name.factor,
                       heading.unit == "deg"};
      if (heading.unit == own.unit) return column;
      column.factor = 0;
      if (heading.unit.empty()) return column;
      for (int k = 0; k <= static_cast<int>(Dimension::voltage); ++k) {
        const auto from = si_per(heading.unit, static_cast<Dimension>(k)),
                   to = si_per(own.unit, static_cast<Dimension>(k));
        if (from && to) column.factor = *from / *to;
      }
      if (column.factor > 0) return column;
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

Json angle_in(const CsvTable& table, std::string_view cell, const RunColumn& column) {
  const bool number = table.number_in(cell).has_value();
  const std::string text = number ? table.with_point(cell) + (column.degrees ? "deg" : "")
                                  : campaign_angle(table.with_point(cell));
  const auto radians = parse_angle(text);
  if (!radians)
    table.fail(cell, fmt::format("`{}` is no angle; write a number, \"pi/3\" or \"60deg\"", cell));
  if (const std::string slip = angle_slip(*radians); !slip.empty())
    table.fail(cell, fmt::format("`{}` {}", cell, slip));
  const bool as_written = !parse_number(text) && column.key->kind.form != Kind::above_zero;
  return as_written ? Json(text) : Json(*radians);
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
  if (column.factor == 0 && table.number_in(cell))
    table.fail(cell, fmt::format("`{}` has no unit: name its column {}, or another unit", cell, column.name));
  if (column.key->quantity().ends_with("_rad")) return angle_in(table, cell, column);
  return column.factor * table.number(cell);
}

/// Keys of a run that a table of alpha and v may give.
const std::vector<std::string> kOfAlphaV = {
    "name",           "cycles", "phi_rad",   "dtau_rad",     "alpha_rad",
    "alpha_sd_rad",   "v_mm_s", "v_sd_mm_s", "amplitude_mm", "angular_frequency_rad_s",
    "start_phase_rad"};

/// What else is taken from a runs.csv.
const std::vector<std::string> kInsteadOfAlpha = {"dx", "dy", "kind", "failure"};

/// The columns of a table. Throws for a key that two of them give.
std::vector<RunColumn> columns_of(const CsvTable& table, const std::vector<std::string>& only) {
  std::vector<RunColumn> columns;
  for (std::size_t k = 0; k < table.header().size(); ++k) {
    const RunColumn column = run_column(table.heading(k), only);
    if (column.key != nullptr && std::ranges::count(columns, column.name, &RunColumn::name) > 0)
      table.fail(table.header()[k], fmt::format("the column `{}` is there twice: one of {} is enough",
                                                table.header()[k], column.name));
    columns.push_back(column);
  }
  return columns;
}

void require_alpha_and_v(const CsvTable& table, const std::vector<RunColumn>& columns,
                         const std::vector<std::string>& unused) {
  for (std::size_t k = 0; k < columns.size(); ++k)
    if (columns[k].key != nullptr && columns[k].factor == 0)
      table.fail(table.header()[k],
                 fmt::format("the column `{}` has no unit that is known in its name; write {}",
                             table.header()[k], columns[k].name));
  for (const char* needed : {"phi_rad", "dtau_rad", "alpha_rad", "v_mm_s"}) {
    if (std::ranges::count(columns, needed, &RunColumn::name) > 0) continue;
    const std::string near = nearest_word(needed, unused);
    table.fail(fmt::format(
        "has no column {}{}: {}; a table of alpha and v has the columns phi_deg, dtau_deg, alpha_deg and "
        "v_mm_s (angles also as _rad), with alpha_sd_deg and v_sd_mm_s where they are known",
        needed, near.empty() ? "" : fmt::format(" (is it `{}`?)", near), table.holds()));
  }
}

CampaignRun run_of(const RunList::Line& line, const Campaign& campaign, bool with_sds = true) {
  StrictTable keys = StrictTable::of(line.keys, line.place);
  CampaignRun run = read_run(keys, campaign, with_sds);
  for (const auto& [key, sd] : line.digits) run.digits[key] = sd;
  return run;
}

/// A table that the campaign names, with its hash and a note of what is not used of it.
RunList listed(const fs::path& path, Campaign& campaign, const std::vector<std::string>& only) {
  if (!fs::is_regular_file(path))
    throw InvalidInput("{}: there is no such table; check [data]", path.string());
  std::string text = read_text(path);
  campaign.table_inputs.push_back(hashed_input(path, text));
  RunList list = read_run_list(path, std::move(text), only);
  if (!list.unused.empty())
    campaign.notes.push_back(fmt::format("{}: not used: {}", path.string(), fmt::join(list.unused, ", ")));
  return list;
}

/// Failed runs and free slides of a runs.csv.
bool is_left_out(const RunList::Line& line, std::vector<std::string>& notes) {
  const bool failed = line.others.contains("failure"), slide = line.other("kind") == "free_slide";
  if (failed || slide)
    notes.push_back(
        fmt::format("{}: left out: {}", line.place,
                    failed ? "the run failed" : "a free slide has no alpha and v; give its track"));
  return failed || slide;
}

/// Direction and its sd from the displacement, where a run of runs.csv has no alpha; of a part at rest any.
void complete_alpha(RunList::Line& line) {
  Json& keys = line.keys;
  if (keys.contains("alpha_rad") || !keys.contains("v_mm_s")) return;
  const auto dx = parse_number(line.other("dx")), dy = parse_number(line.other("dy"));
  const double v = keys["v_mm_s"];
  if (dx && dy && keys.contains("v_sd_mm_s")) {
    keys["alpha_rad"] = std::atan2(*dy, *dx);
    keys["alpha_sd_rad"] = v > 0 ? keys["v_sd_mm_s"].get<double>() / v : 1;
  } else if (v == 0) {
    keys["alpha_rad"] = 0;
  }
}

/// The lines of all tables.
std::vector<CampaignRun> lines_of(Campaign& campaign) {
  std::vector<CampaignRun> runs;
  for (const fs::path& path : campaign.data.tables) {
    const std::size_t before = runs.size();
    for (RunList::Line& line : listed(path, campaign, kOfAlphaV).lines) {
      if (is_left_out(line, campaign.notes)) continue;
      complete_alpha(line);
      runs.push_back(run_of(line, campaign, /*with_sds=*/false));
    }
    if (runs.size() == before)
      throw InvalidInput("{}: has no line of numbers under its header", path.string());
  }
  for (CampaignRun& run : runs) {
    if (!run.alpha_sd) run.alpha_sd = campaign.data.alpha_sd;
    if (!run.v_sd) run.v_sd = campaign.data.v_sd;
  }
  return runs;
}

}  // namespace

RunList read_run_list(const fs::path& path, std::string text, const std::vector<std::string>& only) {
  CsvTable table(path, std::move(text), [&](const Cells& cells) {
    return static_cast<int>(std::ranges::count_if(
        cells, [&](std::string_view cell) { return run_column(heading_of(cell), only).key != nullptr; }));
  });
  if (table.header().empty())
    throw InvalidInput(
        "{}: no line names its columns: {}; a table of runs has the columns video (or track), phi_deg and "
        "dtau_deg, one of alpha and v phi_deg, dtau_deg, alpha_deg and v_mm_s",
        path.string(), table.holds());
  RunList list;
  const std::vector<RunColumn> columns = columns_of(table, only);
  for (std::size_t k = 0; k < columns.size(); ++k) {
    const bool of_alpha = !only.empty() && std::ranges::count(kInsteadOfAlpha, table.heading(k).quantity) > 0;
    if (columns[k].key == nullptr && !of_alpha && !table.header()[k].empty())
      list.unused.emplace_back(table.header()[k]);
  }
  if (!only.empty()) require_alpha_and_v(table, columns, list.unused);
  while (table.next()) {
    RunList::Line line{table.place(), Json::object(), {}, {}};
    for (std::size_t k = 0; k < std::min(table.filled(), columns.size()); ++k) {
      const std::string_view cell = table.cells()[k];
      const RunColumn& column = columns[k];
      if (CsvTable::is_none(cell)) continue;
      if (column.key == nullptr) {
        if (!table.heading(k).sd) line.others[table.heading(k).quantity] = table.with_point(cell);
        continue;
      }
      const Json value = value_in(table, cell, column);
      if (column.key->kind.is_sd() && value == 0) continue;  // exact
      line.keys[column.name] = value;
      if (value.is_number_float())
        line.digits[column.key->name] =
            column.to_named * column.factor * last_digit_sd(table.with_point(cell));
    }
    list.lines.push_back(std::move(line));
  }
  return list;
}

void add_listed_runs(Campaign& campaign) {
  if (!campaign.data.runs) return;
  for (const RunList::Line& line : listed(*campaign.data.runs, campaign, {}).lines)
    campaign.runs.push_back(run_of(line, campaign));
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
