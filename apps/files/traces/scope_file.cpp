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
    "the layouts of Rigol, Tektronix, Keysight, Siglent, PicoScope and Digilent are read, and of any other "
    "oscilloscope a plain table in seconds and volts under the line Time(s),CH1(V),CH2(V)";

namespace {

struct ScopeHeader {
  std::string layout = "time and channels";
  std::vector<std::string> names;         ///< "CH1", ...
  std::vector<std::size_t> columns;       ///< of the channels
  std::vector<double> volt;               ///< V to one of each channel's unit
  std::optional<std::size_t> time;        ///< its column; empty: values alone
  double second = 1;                      ///< s to one of the time's unit
  std::optional<double> start, interval;  ///< s, as the settings have them
  bool at_first_numbers = false;          ///< the table stands at the first row already
};

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

/// A unit alone ("Second", "in s") names the time in the first column only: below, it may be a setting.
bool means_time(const Heading& heading, std::size_t column) {
  const std::string& quantity = heading.quantity;
  if (quantity == "time" || quantity == "t" || quantity == "x-axis" || quantity == "zeit" ||
      quantity == "temps" || quantity == "tiempo" || quantity == "tempo")
    return true;
  return column == 0 && (quantity == "s" || (quantity == "in" && heading.unit == "s"));
}

/// A unit in it, alone or behind a name: to SI.
std::optional<double> unit_in(const Heading& heading, Dimension dimension) {
  return si_per(heading.unit.empty() ? heading.quantity : heading.unit, dimension);
}

/// What stands after "t0 =" or "tInc =".
std::string_view stated(const Cells& cells, std::string_view name) {
  for (const std::string_view cell : cells)
    if (cell.starts_with(name)) return cell.substr(std::min(cell.size(), cell.find('=') + 1));
  return {};
}

/// The number of a piece of text, with or without blanks and its unit s.
std::optional<double> seconds_in(const CsvTable& table, std::string_view text) {
  while (text.starts_with(' ')) text.remove_prefix(1);
  while (text.ends_with(' ') || text.ends_with('s')) text.remove_suffix(1);
  return table.number_in(text);
}

/// Times and channels that a line names; 0 without a time, or start and interval in its place.
int known_in(const Cells& cells) {
  const bool settings =
      !stated(cells, "tInc").empty() || (cells.front() == "X" && std::ranges::count(cells, "Increment") == 1);
  int times = settings ? 1 : 0, names = 0;
  for (std::size_t k = 0; k < cells.size(); ++k) {
    times += means_time(heading_of(cells[k]), k);
    names += !cells[k].empty();
  }
  return times > 0 && names > 1 ? names : 0;
}

/// Reads the lines above the numbers, and rows of settings among the first.
class HeaderReader {
 public:
  explicit HeaderReader(CsvTable& table) : table_(table) {}

  ScopeHeader read() {
    for (const Cells& cells : table_.above()) look_at_settings(cells);
    if (table_.header().empty()) {
      if (tektronix_tds()) return header_;
      throw InvalidInput(
          "{}: is not a known oscilloscope layout: no line above numbers names a time and a channel: {}; {}",
          table_.path().string(), table_.holds(), kScopeLayouts);
    }
    if (!by_settings()) by_time();
    return header_;
  }

 private:
  /// Layouts without a time column.
  bool by_settings() {
    const Cells& names = table_.header();
    const bool in_row = names.front() == "X";
    if (!in_row && stated(names, "tInc").empty()) return false;
    header_.layout = in_row ? "Rigol DS1000Z" : "Rigol MSO5000";
    for (std::size_t k = 0; k < names.size(); ++k)
      if (names[k].starts_with("CH")) add_channel(k);
    if (header_.names.empty())
      table_.fail(fmt::format("is not a known oscilloscope layout: it names no channel (CH1, ...); {}",
                              kScopeLayouts));
    if (in_row) {
      const std::size_t channels = header_.names.size();
      if (!table_.next() || table_.filled() < channels + 3)
        table_.fail("the second line must hold Sequence, the channels' units, start and increment");
      header_.start = table_.number(table_.cells()[channels + 1]);
      header_.interval = table_.number(table_.cells()[channels + 2]);
    } else {
      header_.start = seconds_in(table_, stated(names, "t0")).value_or(0);
      header_.interval = seconds_in(table_, stated(names, "tInc"));
    }
    return true;
  }

  /// Settings in three columns beside the numbers, from the first line on. Those of later lines are not
  /// needed: time and voltage are in s and V.
  bool tektronix_tds() {
    constexpr std::size_t kTime = 3, kValue = 4;
    if (!table_.next() || lower(table_.cells().front()) != "record length" || table_.filled() <= kValue)
      return false;
    header_.layout = "Tektronix TDS";
    header_.time = kTime;
    header_.names = {"CH1"};
    header_.columns = {kValue};
    header_.volt = {1};
    header_.at_first_numbers = true;
    return true;
  }

  void by_time() {
    const Cells& names = table_.header();
    for (std::size_t k = 0; k < names.size() && !header_.time; ++k)
      if (means_time(table_.heading(k), k)) header_.time = k;
    header_.second = unit_in(table_.heading(*header_.time), Dimension::time).value_or(1);
    for (std::size_t k = 0; k < names.size(); ++k)
      if (k != header_.time) add_channel(k);
    // Siglent names its channels `Volt` or `Value`, and says above which they are.
    for (std::size_t k = 0; k < header_.names.size() && sources_.size() >= header_.names.size(); ++k)
      if (!sources_[k].empty()) header_.names[k] = channel_name(sources_[k], k + 1);
    // "V" or "CH1:mV" among the settings.
    for (std::size_t k = 0; k < header_.volt.size() && k < units_.size(); ++k)
      header_.volt[k] = unit_in(heading_of(units_[k].substr(units_[k].find(':') + 1)), Dimension::voltage)
                            .value_or(header_.volt[k]);
    if (header_.names.empty())
      table_.fail(fmt::format("names a time and no channel: {}; {}", table_.holds(), kScopeLayouts));
  }

  void add_channel(std::size_t column) {
    const std::string name = channel_name(table_.header()[column], column);
    if (name.empty() || is_digital(name)) return;
    header_.names.push_back(name);
    header_.columns.push_back(column);
    header_.volt.push_back(unit_in(table_.heading(column), Dimension::voltage).value_or(1));
  }

  void look_at_settings(const Cells& cells) {
    const std::string key = lower(cells.front());
    if (key == "source") sources_.assign(cells.begin() + 1, cells.end());
    if (key == "vertical units") units_.assign(cells.begin() + 1, cells.end());
    if (key == "sample interval" && cells.size() > 1)  // or "Analog:5.0E-05"
      header_.interval = table_.number_in(cells[1].substr(cells[1].find(':') + 1));
  }

  CsvTable& table_;
  ScopeHeader header_;
  std::vector<std::string_view> sources_, units_;
};

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
    table.fail(fmt::format("has {} columns where {} belong: {}", table.filled(), header.columns.back() + 1,
                           table.holds()));
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
      throw InvalidInput("{}: its times go back at sample {}; export the trace again", table.path().string(),
                         k + 1);
    if (times[k] > times[k - 1]) steps.push_back(times[k] - times[k - 1]);
  }
  if (steps.empty()) return;
  const auto rare =
      steps.begin() + static_cast<std::ptrdiff_t>(kRare * static_cast<double>(steps.size() - 1));
  std::nth_element(steps.begin(), rare, steps.end());
  const double allowed = kSlack * std::max(*rare, increment);
  for (std::size_t k = 0; k < times.size(); ++k)
    if (std::abs(times[k] - start - increment * static_cast<double>(k)) > allowed)
      throw InvalidInput(
          "{}: its samples are not evenly spaced (sample {} is {:.3g} s off); export one gapless trace",
          table.path().string(), k + 1, times[k] - start - increment * static_cast<double>(k));
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
    throw InvalidInput("{}: there is no such oscilloscope file; check `scope`", path.string());
  std::string text = read_text(path);
  ScopeFile file;
  file.input = hashed_input(path, text);
  CsvTable table(path, std::move(text), known_in);
  const ScopeHeader header = HeaderReader(table).read();
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
        "{}: is not of the same trace as {}: {} samples from {:.6g} s every {:.6g} s, and {} from {:.6g} s "
        "every {:.6g} s; name the files of one acquisition",
        second.input.path.string(), first.input.path.string(), samples(second), second.start_s,
        second.increment_s, samples(first), first.start_s, first.increment_s);
  first.names.insert(first.names.end(), second.names.begin(), second.names.end());
  first.channels.insert(first.channels.end(), second.channels.begin(), second.channels.end());
}

}  // namespace tribotrack::apps
