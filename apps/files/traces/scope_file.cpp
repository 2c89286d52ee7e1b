#include "apps/files/traces/scope_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <utility>

#include "apps/program/errors.h"
#include "apps/text/angle.h"
#include "apps/text/csv_table.h"
#include "apps/text/strict_toml.h"

namespace tribotrack::apps {

const char* const kScopeLayouts =
    "the layouts of Rigol, Tektronix, Keysight, Siglent and PicoScope are read, and of any other "
    "oscilloscope a "
    "plain table in seconds and volts under the line Time(s),CH1(V),CH2(V)";

namespace {

std::string lower(std::string_view text) {
  std::string kept(text);
  for (char& c : kept)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return kept;
}

bool is_number(const CsvTable& table, std::string_view cell) {
  return parse_number(table.with_point(cell)).has_value();
}

/// "CH2(V)" -> "CH2", "X(CH1)" -> "CH1", "Channel A" -> "Channel A", "2" -> "CH2", "Volt" -> by its column.
std::string channel_name(std::string_view cell, std::size_t column) {
  const auto at = cell.find("CH");
  if (at != std::string_view::npos) {
    auto end = at + 2;
    while (end < cell.size() && cell[end] >= '0' && cell[end] <= '9') ++end;
    if (end > at + 2) return std::string(cell.substr(at, end - at));
  }
  if (!cell.empty() && cell.find_first_not_of("0123456789") == std::string_view::npos)
    return "CH" + std::string(cell);
  std::string name(cell.substr(0, cell.find_first_of("([")));
  while (name.ends_with(' ')) name.pop_back();
  const bool unit_alone = lower(name) == "volt" || lower(name) == "value";
  return unit_alone ? fmt::format("CH{}", column) : name;
}

/// A digital line of a mixed-signal oscilloscope.
bool is_digital(const std::string& name) {
  return name.size() > 1 && (name[0] == 'D' || name[0] == 'd') &&
         name.find_first_not_of("0123456789", 1) == std::string::npos;
}

bool means_time(std::string_view cell) {
  const std::string quantity = heading_of(cell).quantity;
  return quantity == "time" || quantity == "t" || quantity == "x-axis" || quantity == "s" ||
         quantity == "zeit" || quantity == "temps" || quantity == "tiempo";
}

/// Of "(ms)", "ms", "Second", "Time (us)": s to one.
std::optional<double> unit_in(std::string_view cell, Dimension dimension) {
  const Heading alone = heading_of("x " + std::string(cell));  // a unit by itself is no first word
  if (const auto si = si_per(alone.unit, dimension)) return si;
  return si_per(heading_of(cell).unit, dimension);
}

/// The number after "t0 =" or "tInc =", with or without its unit s.
std::optional<double> stated(const CsvTable& table, std::string_view name) {
  for (const std::string_view cell : table.cells()) {
    if (!cell.starts_with(name)) continue;
    std::string_view value = cell.substr(std::min(cell.size(), cell.find('=') + 1));
    if (value.ends_with('s')) value.remove_suffix(1);
    while (value.starts_with(' ')) value.remove_prefix(1);
    while (value.ends_with(' ')) value.remove_suffix(1);
    return table.number(value);
  }
  return std::nullopt;
}

/// The number of a setting, "Analog:5.0E-05" included; nothing where it is none.
std::optional<double> setting(const CsvTable& table) {
  if (table.cells().size() < 2) return std::nullopt;
  std::string value = table.with_point(table.cells()[1]);
  value.erase(0, value.find(':') == std::string::npos ? 0 : value.find(':') + 1);
  return parse_number(value);
}

/// Reads line by line.
class Reader {
 public:
  explicit Reader(CsvTable& table) : table_(table) {}

  ScopeHeader read() {
    constexpr int kLinesLookedAt = 60;
    for (int line = 0; line < kLinesLookedAt && table_.next(); ++line) {
      if (line == 0 && by_first_line()) return header_;
      if (tektronix_tds()) return header_;
      if (!header_.names.empty() && header_.time && is_number(table_, table_.cells().front())) {
        header_.at_first_numbers = true;
        finish();
        return header_;
      }
      look_at_line();
    }
    if (table_.line() == 0) table_.fail("the file is empty; export the trace again");
    if (!header_.names.empty() && header_.time) return header_;  // and no numbers below
    throw InvalidInput(fmt::format(
        "{}:1: is not a known oscilloscope layout: no line above numbers names a time and a channel; {}",
        table_.path().string(), kScopeLayouts));
  }

 private:
  /// Layouts without a time column.
  bool by_first_line() {
    const auto& cells = table_.cells();
    const auto start = stated(table_, "t0"), interval = stated(table_, "tInc");
    if (start && interval) {
      header_.layout = "Rigol MSO5000";
      header_.start = start;
      header_.interval = interval;
      for (std::size_t k = 0; k < cells.size(); ++k)
        if (cells[k].starts_with("CH")) add_channel(k);
      return require_channels();
    }
    if (cells.front() != "X" || std::count(cells.begin(), cells.end(), "Increment") != 1) return false;
    header_.layout = "Rigol DS1000Z";
    for (std::size_t k = 1; k < cells.size(); ++k)
      if (cells[k].starts_with("CH")) add_channel(k);
    const std::size_t channels = header_.names.size();
    require_channels();
    if (!table_.next() || table_.filled() < channels + 3)
      table_.fail("the second line must hold Sequence, the channels' units, start and increment");
    header_.start = table_.number(table_.cells()[channels + 1]);
    header_.interval = table_.number(table_.cells()[channels + 2]);
    return true;
  }

  bool require_channels() const {
    if (header_.names.empty())
      table_.fail(
          fmt::format("is not a known oscilloscope layout: its first line names no channel (CH1, ...); {}",
                      kScopeLayouts));
    return true;
  }

  /// Settings in three columns beside the numbers, from the first line on. Those of later lines are not
  /// needed: time and voltage are in s and V.
  bool tektronix_tds() {
    constexpr std::size_t kTime = 3, kValue = 4;
    const auto& cells = table_.cells();
    if (lower(cells.front()) != "record length" || table_.filled() <= kValue) return false;
    if (!is_number(table_, cells[kTime]) || !is_number(table_, cells[kValue])) return false;
    header_.layout = "Tektronix TDS";
    header_.time = kTime;
    header_.names = {"CH1"};
    header_.columns = {kValue};
    header_.volt = {1};
    header_.at_first_numbers = true;
    return true;
  }

  void add_channel(std::size_t column) {
    const std::string name = channel_name(table_.cells()[column], column);
    if (name.empty() || is_digital(name)) return;
    header_.names.push_back(name);
    header_.columns.push_back(column);
    header_.volt.push_back(unit_in(table_.cells()[column], Dimension::voltage).value_or(1));
  }

  /// A setting, the channels' names, or their units.
  void look_at_line() {
    const auto& cells = table_.cells();
    const std::string key = lower(cells.front());
    if (key == "model") header_.layout = "Tektronix";
    if (key == "record length" || key == "source") {
      if (header_.layout.empty()) header_.layout = "Siglent";
    }
    if (key == "sample interval") header_.interval = setting(table_);
    if (key == "source") sources_.assign(cells.begin() + 1, cells.end());
    if (key == "vertical units") units_.assign(cells.begin() + 1, cells.end());
    if (is_units_line()) return take_units();
    if (!means_time(cells.front())) return;
    name_layout(key);
    header_.time = 0;
    header_.second = unit_in(cells.front(), Dimension::time).value_or(1);
    header_.names.clear();
    header_.columns.clear();
    header_.volt.clear();
    for (std::size_t k = 1; k < table_.filled(); ++k) add_channel(k);
    name_by_sources();
  }

  void name_layout(const std::string& key) {
    if (!header_.layout.empty()) return;
    const auto& cells = table_.cells();
    const bool pico = std::ranges::any_of(cells, [](std::string_view cell) {
      const std::string name = lower(cell);
      return name.starts_with("channel ") || name.starts_with("kanal ");
    });
    const bool by_x =
        std::ranges::any_of(cells, [](std::string_view cell) { return cell.starts_with("X(CH"); });
    header_.layout = key == "x-axis"    ? "Keysight"
                     : pico             ? "PicoScope"
                     : by_x             ? "Rigol DS1102E"
                     : key == "time(s)" ? "Rigol MSO5000"
                                        : "Time, channels";
  }

  /// Siglent names its channels `Volt` or `Value`, and says above which they are.
  void name_by_sources() {
    if (sources_.size() < header_.names.size()) return;
    for (std::size_t k = 0; k < header_.names.size(); ++k)
      if (!sources_[k].empty()) header_.names[k] = channel_name(sources_[k], k + 1);
  }

  /// Units under the names: the time's is one, and every other cell is one or empty.
  bool is_units_line() const {
    return header_.time && !header_.names.empty() && heading_of(table_.cells().front()).unit.empty() &&
           unit_in(table_.cells().front(), Dimension::time).has_value();
  }

  void take_units() {
    header_.second = unit_in(table_.cells().front(), Dimension::time).value_or(header_.second);
    for (std::size_t k = 0; k < header_.columns.size(); ++k)
      if (header_.columns[k] < table_.cells().size())
        header_.volt[k] =
            unit_in(table_.cells()[header_.columns[k]], Dimension::voltage).value_or(header_.volt[k]);
  }

  /// What the settings said of units, "V" or "CH1:mV".
  void finish() {
    for (std::size_t k = 0; k < header_.volt.size() && k < units_.size(); ++k) {
      const std::string unit =
          units_[k].substr(units_[k].find(':') == std::string::npos ? 0 : units_[k].find(':') + 1);
      header_.volt[k] = unit_in(unit, Dimension::voltage).value_or(header_.volt[k]);
    }
  }

  CsvTable& table_;
  ScopeHeader header_;
  std::vector<std::string> sources_, units_;
};

}  // namespace

ScopeHeader read_scope_header(CsvTable& table) {
  return Reader(table).read();
}

namespace {

constexpr std::size_t kFewestSamples = 100;

/// PicoScope writes it for what lies beyond the channel's range.
bool is_beyond_range(std::string_view cell) {
  return cell.find("\xe2\x88\x9e") != std::string_view::npos ||
         cell.find("nfinity") != std::string_view::npos;
}

double voltage(const CsvTable& table, std::string_view cell) {
  if (is_beyond_range(cell))
    table.fail(cell, "the signal was beyond the channel's range; record it again with a larger one");
  return table.number(cell);
}

/// Appends the line's values. A line without all of them may stand before the first whole one, as Keysight
/// writes it, and after the last: false.
bool append(const CsvTable& table, const ScopeHeader& header, ScopeFile& file) {
  const auto& cells = table.cells();
  std::size_t there = 0, filled = 0;
  for (const std::size_t column : header.columns) {
    there += column < cells.size();
    filled += column < cells.size() && !cells[column].empty();
  }
  if (filled < header.columns.size()) {
    if (header.time && there == header.columns.size() && filled == 0) return false;
    table.fail(fmt::format("has {} columns where {} belong", table.filled(), header.columns.back() + 1));
  }
  for (std::size_t c = 0; c < header.columns.size(); ++c)
    file.channels[c].push_back(header.volt[c] * voltage(table, cells[header.columns[c]]));
  return true;
}

/// Printed times are rounded, by many increments at worst; they are even where none is further from the grid
/// than their own steps.
void require_even(const CsvTable& table, const std::vector<double>& times, double start, double increment) {
  constexpr double kRare = 0.99, kSlack = 1.5;
  std::vector<double> steps;
  for (std::size_t k = 1; k < times.size(); ++k) {
    if (times[k] < times[k - 1])
      throw InvalidInput(fmt::format("{}: its times go back at sample {}; export the trace again",
                                     table.path().string(), k + 1));
    if (times[k] > times[k - 1]) steps.push_back(times[k] - times[k - 1]);
  }
  if (steps.empty()) return;
  const auto rare =
      steps.begin() + static_cast<std::ptrdiff_t>(kRare * static_cast<double>(steps.size() - 1));
  std::nth_element(steps.begin(), rare, steps.end());
  const double allowed = kSlack * std::max(*rare, increment);
  for (std::size_t k = 0; k < times.size(); ++k)
    if (std::abs(times[k] - start - increment * static_cast<double>(k)) > allowed)
      throw InvalidInput(fmt::format(
          "{}: its samples are not evenly spaced (sample {} is {:.3g} s off); export one gapless trace",
          table.path().string(), k + 1, times[k] - start - increment * static_cast<double>(k)));
}

/// Start and increment from the printed times; the interval of the settings has all digits, where it is that
/// of these samples.
void settle_times(const CsvTable& table, const ScopeHeader& header, const std::vector<double>& times,
                  ScopeFile& file) {
  constexpr double kAgrees = 1e-3;
  if (times.size() < 2) return;
  file.start_s = times.front();
  file.increment_s = (times.back() - times.front()) / static_cast<double>(times.size() - 1);
  if (header.interval && *header.interval > 0 && std::abs(file.increment_s / *header.interval - 1) < kAgrees)
    file.increment_s = *header.interval;
  require_even(table, times, file.start_s, file.increment_s);
}

}  // namespace

bool may_be_trace(const std::filesystem::path& path) {
  constexpr std::array endings = {".csv", ".CSV", ".txt", ".TXT", ".tsv", ".dat"};
  return std::ranges::find(endings, path.extension().string()) != endings.end();
}

ScopeFile read_scope_file(const std::filesystem::path& path) {
  if (!std::filesystem::is_regular_file(path))
    throw InvalidInput(fmt::format("{}: there is no such oscilloscope file; check `scope`", path.string()));
  std::string text = read_text(path);
  ScopeFile file;
  file.input = hashed_input(path, text);
  CsvTable table(path, std::move(text));
  const ScopeHeader header = read_scope_header(table);
  file.layout = header.layout;
  file.names = header.names;
  file.channels.resize(header.names.size());
  if (header.start) file.start_s = *header.start;
  if (header.interval) file.increment_s = *header.interval;
  std::vector<double> times;
  bool ended = false;
  for (bool more = header.at_first_numbers || table.next(); more; more = table.next()) {
    const bool whole = append(table, header, file);
    if (whole && ended) table.fail("follows a line without values; export one gapless trace");
    ended = !whole && !file.channels.front().empty();
    if (whole && header.time) times.push_back(header.second * table.number(table.cells()[*header.time]));
  }
  if (header.time) settle_times(table, header, times, file);
  if (file.channels.front().size() < kFewestSamples)
    table.fail(fmt::format("the trace has {} samples; at least {} are needed", file.channels.front().size(),
                           kFewestSamples));
  if (!(file.increment_s > 0)) table.fail("the time between samples must be greater than 0");
  return file;
}

void add_channels(const ScopeFile& second, ScopeFile& first) {
  const auto samples = [](const ScopeFile& file) {
    return file.channels.empty() ? std::size_t{0} : file.channels.front().size();
  };
  const double apart = std::abs(second.start_s - first.start_s);
  if (samples(second) != samples(first) || apart > 0.5 * first.increment_s ||
      std::abs(second.increment_s / first.increment_s - 1) * static_cast<double>(samples(first)) > 0.5)
    throw InvalidInput(
        fmt::format("{}: is not of the same trace as {}: {} samples from {:.6g} s every {:.6g} s, and {} "
                    "from {:.6g} s every "
                    "{:.6g} s; name the files of one acquisition",
                    second.input.path.string(), first.input.path.string(), samples(second), second.start_s,
                    second.increment_s, samples(first), first.start_s, first.increment_s));
  first.names.insert(first.names.end(), second.names.begin(), second.names.end());
  first.channels.insert(first.channels.end(), second.channels.begin(), second.channels.end());
}

}  // namespace tribotrack::apps
