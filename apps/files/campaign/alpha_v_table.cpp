#include "apps/files/campaign/alpha_v_table.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "apps/program/errors.h"
#include "apps/text/angle.h"
#include "apps/text/csv_table.h"
#include "apps/text/strict_toml.h"

namespace tribotrack::apps {

namespace {

constexpr double kTurn = 2 * std::numbers::pi;
/// No speed, length or frequency of a lab is larger, and its square can be added up.
constexpr double kBeyondAll = 1e7;
/// rad, m/s: what is called better known than that is no measurement.
constexpr double kLeastSd = 1e-15;

constexpr const char* kWanted =
    "a table of alpha and v has the columns phi_deg, dtau_deg, alpha_deg and v_mm_s (angles also as _rad), "
    "with alpha_sd_deg and v_sd_mm_s where they are known";

/// What a column may hold: the dimensions its unit may have (none: a text), how that may be written, and
/// where a run keeps it.
struct Quantity {
  std::vector<std::string_view> names;
  std::vector<Dimension> dimensions = {};
  const char* write = "";
  Value (*value)(CampaignRun&) = nullptr;
  Value (*sd)(CampaignRun&) = nullptr;
  bool measured = false;  ///< not a condition, of which an sd of 0 says that it is exact

  std::string_view name() const { return names.front(); }
  /// Of a run.
  std::string key() const {
    return std::string(std::string_view(write).substr(0, std::string_view(write).find(' ')));
  }
  bool is_angle() const { return !dimensions.empty() && dimensions.front() == Dimension::angle; }
  /// Factor to SI of a unit; 0 for one of another dimension.
  double si(const std::string& unit) const {
    for (const Dimension dimension : dimensions)
      if (const auto found = si_per(unit, dimension))
        return dimension == Dimension::frequency ? kTurn * *found : *found;
    return 0;
  }
};

const std::vector<Quantity>& quantities() {
  using R = CampaignRun;
  using enum Dimension;
  static const std::vector<Quantity> all = {
      {{"phi"}, {angle}, "phi_rad or phi_deg", at<&R::phi>, at<&R::phi_sd>},
      {{"dtau", "d_tau", "delta_tau"}, {angle}, "dtau_rad or dtau_deg", at<&R::dtau>, at<&R::dtau_sd>},
      {{"alpha"}, {angle}, "alpha_rad or alpha_deg", at<&R::alpha>, at<&R::alpha_sd>, true},
      {{"v", "velocity", "speed"}, {velocity}, "v_mm_s or v_m_s", at<&R::v>, at<&R::v_sd>, true},
      {{"amplitude"}, {length}, "amplitude_mm", at<&R::amplitude>, at<&R::amplitude_sd>},
      {{"angular_frequency", "w", "omega", "frequency", "f"},
       {angular_frequency, frequency},
       "angular_frequency_rad_s or frequency_hz",
       at<&R::angular_frequency>,
       at<&R::angular_frequency_sd>},
      {{"start_phase"},
       {angle},
       "start_phase_rad or start_phase_deg",
       at<&R::start_phase>,
       at<&R::start_phase_sd>},
      {{"dx"}, {length}, "dx_mm"},
      {{"dy"}, {length}, "dy_mm"},
      {{"name", "run"}},
      {{"cycles"}},
      {{"kind"}},
      {{"failure"}}};
  return all;
}

/// Nothing for a heading that is none of these.
const Quantity* quantity_of(const Heading& heading) {
  const bool text = heading.unit.empty() && !heading.sd;
  for (const Quantity& quantity : quantities())
    if (std::ranges::count(quantity.names, heading.quantity) > 0 && (text || !quantity.dimensions.empty()))
      return &quantity;
  return nullptr;
}

int known_in(const Cells& cells) {
  return static_cast<int>(std::ranges::count_if(
      cells, [](std::string_view cell) { return quantity_of(heading_of(cell)) != nullptr; }));
}

/// The header line.
class Columns {
 public:
  explicit Columns(const CsvTable& table) : columns_(table.header().size()) {
    if (columns_.empty())
      throw InvalidInput(fmt::format("{}: no line names its columns: {}; {}", table.path().string(),
                                     table.holds(), kWanted));
    for (std::size_t k = 0; k < columns_.size(); ++k) {
      const std::string_view cell = table.header()[k];
      const Heading heading = table.heading(k);
      if (const Quantity* quantity = quantity_of(heading))
        columns_[k] = column_of(table, cell, heading, *quantity);
      else if (!cell.empty())
        unused_.emplace_back(cell);
    }
    for (const char* needed : {"phi", "dtau", "alpha", "v"})
      if (!find(needed)) refuse_without(table, needed);
  }

  /// Its index.
  std::optional<std::size_t> find(std::string_view name, bool sd = false) const {
    const auto found = std::ranges::find_if(columns_, [&](const Column& column) {
      return column.quantity != nullptr && column.quantity->name() == name && column.sd == sd;
    });
    if (found == columns_.end()) return std::nullopt;
    return static_cast<std::size_t>(found - columns_.begin());
  }
  double si(std::size_t column) const { return columns_[column].si; }
  bool is_angle(std::size_t column) const { return columns_[column].quantity->is_angle(); }
  const std::vector<std::string>& unused() const { return unused_; }

 private:
  struct Column {
    const Quantity* quantity = nullptr;  ///< null: not used
    bool sd = false;
    double si = 1;
  };

  Column column_of(const CsvTable& table, std::string_view cell, const Heading& heading,
                   const Quantity& quantity) const {
    const bool text = quantity.dimensions.empty();
    if (!text && heading.unit.empty())
      table.fail(cell, fmt::format("the column `{}` has no unit that is known in its name; write {}{}", cell,
                                   quantity.write, heading.sd ? ", with sd in it" : ""));
    const double si = text ? 1 : quantity.si(heading.unit);
    if (si == 0)
      table.fail(cell, fmt::format("the column `{}` is in `{}`, which is no unit of {}; write {}", cell,
                                   heading.unit, quantity.name(), quantity.write));
    if (find(quantity.name(), heading.sd))
      table.fail(cell, fmt::format("the column `{}` is there twice: one of {}{} is enough", cell,
                                   heading.sd ? "the sd of " : "", quantity.name()));
    return {&quantity, heading.sd, si};
  }

  [[noreturn]] void refuse_without(const CsvTable& table, const std::string& needed) const {
    std::vector<std::string> words;
    for (const std::string& column : unused_) words.push_back(heading_of(column).quantity);
    const std::string near = nearest_word(needed, words);
    const auto meant = std::ranges::find(words, near);
    table.fail(fmt::format(
        "has no column {}{}: {}; {}", needed,
        near.empty()
            ? ""
            : fmt::format(" (is it `{}`?)", unused_[static_cast<std::size_t>(meant - words.begin())]),
        table.holds(), kWanted));
  }

  std::vector<Column> columns_;
  std::vector<std::string> unused_;
};

/// The cells of one line.
class Row {
 public:
  Row(const CsvTable& table, const Columns& columns) : table_(table), columns_(columns) {}

  std::string_view text(std::string_view name, bool sd = false) const {
    const auto column = columns_.find(name, sd);
    return column && *column < table_.cells().size() ? table_.cells()[*column] : std::string_view();
  }

  /// SI; nothing for an empty cell.
  std::optional<double> value(std::string_view name, bool sd = false) const {
    const std::string_view cell = text(name, sd);
    if (CsvTable::is_none(cell)) return std::nullopt;
    const std::size_t column = *columns_.find(name, sd);
    const double si = columns_.si(column);
    const double value = columns_.is_angle(column) ? angle(cell, si) : si * table_.number(cell);
    if (std::abs(value) > kBeyondAll)
      table_.fail(cell, fmt::format("`{}` is out of range for {}", cell, name));
    return value;
  }
  void require(std::string_view name) const {
    if (!value(name)) table_.fail(fmt::format("has no {}; fill in the cell, or take the line out", name));
  }
  std::optional<double> sd(const Quantity& quantity) const {
    const auto found = value(quantity.name(), true);
    if (!found || (*found == 0 && !quantity.measured)) return std::nullopt;
    if (!(*found > kLeastSd))
      fail(quantity.name(),
           fmt::format("the sd of {} must be greater than 0; leave the cell empty where it is not known",
                       quantity.name()),
           true);
    return found;
  }
  /// last_digit_sd() in the unit of the run's key; 0 for an empty cell.
  double last_digit(const Quantity& quantity) const {
    const std::string written = table_.with_point(text(quantity.name()));
    if (!parse_number(written)) return last_digit_sd(written);
    const double si = columns_.si(*columns_.find(quantity.name()));
    return last_digit_sd(written) * si / (quantity.key().ends_with("_mm") ? 1e-3 : 1);
  }
  [[noreturn]] void fail(std::string_view name, const std::string& what, bool sd = false) const {
    table_.fail(text(name, sd), what);
  }

 private:
  double angle(std::string_view cell, double si) const {
    const std::string written = table_.with_point(cell);
    const auto number = parse_number(written);
    const auto radians = number ? std::optional(*number * si) : parse_angle(written);
    if (!radians)
      table_.fail(cell, fmt::format("`{}` is no angle; write a number, \"pi/3\" or \"60deg\"", cell));
    if (std::abs(*radians) > 2 * kTurn)
      table_.fail(cell, fmt::format("`{}` is more than two turns{}", cell,
                                    number && si == 1 ? ": degrees? then name the column with _deg" : ""));
    return *radians;
  }

  const CsvTable& table_;
  const Columns& columns_;
};

/// Direction and its sd from the displacement, where a run of runs.csv has no alpha; false where it has none.
bool direction_from_displacement(const Row& cells, CampaignRun& run) {
  const auto dx = cells.value("dx"), dy = cells.value("dy");
  if (!dx || !dy || !run.v_sd) return false;
  run.alpha = std::atan2(*dy, *dx);
  run.alpha_sd = *run.v > 0 ? *run.v_sd / *run.v : 1;
  return true;
}

CampaignRun read_line(const CsvTable& table, const Columns& columns, const FitSection& otherwise) {
  const Row cells(table, columns);
  CampaignRun run;
  run.place = table.place();
  run.name = cells.text("name");
  run.start = otherwise.start;
  run.cycles = otherwise.cycles;
  for (const Quantity& quantity : quantities()) {
    if (quantity.value == nullptr) continue;
    if (const auto value = cells.value(quantity.name())) set_value(quantity.value(run), *value);
    if (const double sd = cells.last_digit(quantity); sd > 0) run.digits[quantity.key()] = sd;
    if (const auto sd = cells.sd(quantity)) set_value(quantity.sd(run), *sd);
  }
  for (const char* name : {"phi", "dtau", "v"}) cells.require(name);
  if (!(run.dtau >= 0 && run.dtau <= kTurn * (1 + 1e-9)))
    cells.fail("dtau", "dtau must lie between 0 and a whole turn");
  run.dtau = std::min(run.dtau, kTurn);
  if (*run.v < 0) cells.fail("v", "v must be 0 or more: its direction is alpha");
  if (!run.alpha && *run.v > 0 && !direction_from_displacement(cells, run)) cells.require("alpha");
  if (!run.alpha) run.alpha = 0;
  if (run.amplitude && *run.amplitude < 0) cells.fail("amplitude", "amplitude must be 0 or more");
  if (run.angular_frequency && !(*run.angular_frequency > 0))
    cells.fail("angular_frequency", "the frequency must be greater than 0");
  if (const std::string_view cell = cells.text("cycles"); !cell.empty()) {
    constexpr double kMostCycles = 1e6;
    const double count = table.number(cell);
    if (!(count >= 1 && count <= kMostCycles) || count != std::floor(count))
      table.fail(cell, fmt::format("`{}` is no number of cycles; it must be whole, 1 to 1000000", cell));
    run.cycles = static_cast<int>(count);
  }
  return run;
}

/// Failed runs and free slides of a runs.csv.
bool is_left_out(const CsvTable& table, const Columns& columns, std::vector<std::string>& notes) {
  const Row cells(table, columns);
  const bool failed = !cells.text("failure").empty(), slide = cells.text("kind") == "free_slide";
  if (failed || slide)
    notes.push_back(
        fmt::format("{}: left out: {}", table.place(),
                    failed ? "the run failed" : "a free slide has no alpha and v; give its track"));
  return failed || slide;
}

}  // namespace

AlphaVTable read_alpha_v_table(const std::filesystem::path& path, const FitSection& otherwise) {
  if (!std::filesystem::is_regular_file(path))
    throw InvalidInput(fmt::format("{}: there is no such table; check `table` in [data]", path.string()));
  std::string text = read_text(path);
  AlphaVTable result;
  result.input = hashed_input(path, text);
  CsvTable table(path, std::move(text), known_in);
  const Columns columns(table);
  while (table.next())
    if (!is_left_out(table, columns, result.notes))
      result.runs.push_back(read_line(table, columns, otherwise));
  if (result.runs.empty())
    throw InvalidInput(fmt::format("{}: has no line of numbers under its header", path.string()));
  if (!columns.unused().empty())
    result.notes.push_back(fmt::format("{}: not used: {}", path.string(), fmt::join(columns.unused(), ", ")));
  return result;
}

}  // namespace tribotrack::apps
