#include "apps/files/campaign/data_section.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <utility>

#include "apps/files/campaign/alpha_v_table.h"
#include "apps/files/campaign/campaign.h"
#include "apps/files/campaign/keys.h"
#include "apps/program/errors.h"
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

/// The lines of all tables, sorted into points, and the points' pooled values.
class TableRuns {
 public:
  explicit TableRuns(Campaign& campaign) : campaign_(campaign) {
    for (const fs::path& path : campaign.data.tables) {
      AlphaVTable table = read_alpha_v_table(path, campaign.fit);
      campaign.table_inputs.push_back(table.input);
      for (std::string& note : table.notes) campaign.notes.push_back(std::move(note));
      for (CampaignRun& line : table.runs) lines_.push_back(std::move(line));
    }
    for (CampaignRun& line : lines_) {
      if (!line.alpha_sd) line.alpha_sd = campaign.data.alpha_sd;
      if (!line.v_sd) line.v_sd = campaign.data.v_sd;
    }
    sort_into_points();
  }

  void add() {
    std::vector<fit::PointMeasurement> measurements;
    for (std::size_t k = 0; k < lines_.size(); ++k) {
      const CampaignRun& line = lines_[k];
      measurements.push_back(
          {point_of_[k], {{*line.alpha, line.alpha_sd.value_or(0)}, {*line.v, line.v_sd.value_or(0)}}});
    }
    const fit::PooledPoints pooled = fit::pool_points(measurements);
    for (std::size_t p = 0; p < points_.size(); ++p) add_run(points_[p], pooled.points[p], pooled);
    note(pooled);
  }

 private:
  void sort_into_points() {
    PointsByPlace known;
    for (const CampaignRun& line : lines_) {
      const auto repeated = known.find(
          line, [&](std::size_t point) { return same_point(lines_[points_[point].front()], line); });
      const std::size_t number = repeated.value_or(points_.size());
      if (!repeated) {
        points_.emplace_back();
        known.add(line, number);
      }
      points_[number].push_back(static_cast<std::size_t>(&line - lines_.data()));
      point_of_.push_back(number);
    }
  }

  void add_run(const std::vector<std::size_t>& members, const fit::AlphaV& value,
               const fit::PooledPoints& pooled) {
    for (const std::size_t k : members)
      if ((!lines_[k].alpha_sd && !(value.alpha.sd > 0)) || (!lines_[k].v_sd && !(value.velocity.sd > 0)))
        refuse_without_sd(lines_[k], pooled);
    CampaignRun run = lines_[members.front()];
    if (run.name.empty()) {
      const fs::path place = run.place;  // "folder/alpha_v.csv:7"
      const std::string line = place.extension().string();
      run.name = place.stem().string() + line.substr(std::min(line.find(':'), line.size()));
    }
    run.alpha = value.alpha.value;
    run.alpha_sd = value.alpha.sd;
    run.v = value.velocity.value;
    run.v_sd = value.velocity.sd;
    if (members.size() > 1)
      for (const std::size_t k : members) run.pooled_from.push_back(lines_[k].place);
    campaign_.runs.push_back(std::move(run));
  }

  void note(const fit::PooledPoints& pooled) {
    const std::size_t repeated = lines_.size() - points_.size();
    if (repeated > 0)
      campaign_.notes.push_back(
          fmt::format("{} lines of tables are {} points: repeats of one point are pooled into their mean",
                      lines_.size(), points_.size()));
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
      campaign_.notes.push_back(
          fmt::format("lines without an sd have that of the scatter between repeats: of one measurement {} "
                      "({} degree{} of "
                      "freedom), widened {:.2f} times, so that 95 % intervals are Student's",
                      fmt::join(sds, ", "), dof, dof == 1 ? "" : "s", pooled.widened));
    }
    if (pooled.scattered > 1)
      campaign_.warnings.push_back(fmt::format(
          "repeats in the tables scatter {:.2g} times as much as their sds say (chi2 {:.3g} at {} degrees of "
          "freedom): the sds of all their lines are widened by that",
          pooled.scattered, pooled.chi2, pooled.chi2_dof));
  }

  Campaign& campaign_;
  std::vector<CampaignRun> lines_;
  std::vector<std::vector<std::size_t>> points_;  ///< the lines of each
  std::vector<std::size_t> point_of_;             ///< of each line
};

}  // namespace

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
  if (!campaign.data.tables.empty()) TableRuns(campaign).add();
}

}  // namespace tribotrack::apps
