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

namespace {

constexpr const char* kScopeLayouts =
    "the layouts of Rigol, Tektronix, Keysight, Siglent, PicoScope and Digilent are read, and of any other "
    "oscilloscope a plain table in seconds and volts under the line Time(s),CH1(V),CH2(V)";

struct Channel {
  std::string name;  ///< "CH1", ...
  std::size_t column = 0;
  double volt = 1;  ///< V to one of its unit
};

/// Where a row holds what.
struct TraceColumns {
  std::vector<Channel> channels;
  std::optional<std::size_t> time = {};  ///< empty: values alone
  double second = 1;                     ///< s to one of the time's unit
  bool at_first_numbers = false;         ///< the table stands at the first row already
};

/// "CH2(V)" -> "CH2", "X(CH1)" -> "CH1", "Channel A" -> "Channel A", "2" -> "CH2", "Volt" -> by its column.
std::string channel_name(std::string_view cell, std::size_t column) {
  if (const auto at = cell.find("CH"); at != cell.npos) {
    const auto end = std::min(cell.find_first_not_of("0123456789", at + 2), cell.size());
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
  constexpr std::array kTimes = {"time", "t", "x-axis", "zeit", "temps", "tiempo", "tempo"};
  const std::string& quantity = heading.quantity;
  if (std::ranges::find(kTimes, quantity) != kTimes.end()) return true;
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

/// What a line above the numbers sets under this name, column by column.
Cells setting(const CsvTable& table, const char* name) {
  Cells values;
  for (const Cells& cells : table.above())
    if (lower(cells.front()) == name) values.assign(cells.begin() + 1, cells.end());
  return values;
}

void add_channel(const CsvTable& table, std::size_t column, std::vector<Channel>& channels) {
  const std::string name = channel_name(table.header()[column], column);
  if (name.empty() || is_digital(name)) return;
  channels.push_back({name, column, unit_in(table.heading(column), Dimension::voltage).value_or(1)});
}

/// Without a header: settings in three columns beside the numbers, from the first line on. Those of later
/// lines are not needed: time and voltage are in s and V.
TraceColumns tektronix_tds(CsvTable& table, ScopeFile& file) {
  constexpr std::size_t kTime = 3, kValue = 4;
  if (!table.next() || lower(table.cells().front()) != "record length" || table.filled() <= kValue)
    throw InvalidInput(
        "{}: is not a known oscilloscope layout: no line above numbers names a time and a channel: {}; {}",
        table.path().string(), table.holds(), kScopeLayouts);
  file.layout = "Tektronix TDS";
  return {{{"CH1", kValue}}, kTime, 1, true};
}

/// Layouts without a time column.
TraceColumns by_settings(CsvTable& table, ScopeFile& file) {
  const Cells& names = table.header();
  const bool in_row = names.front() == "X";
  file.layout = in_row ? "Rigol DS1000Z" : "Rigol MSO5000";
  TraceColumns columns;
  for (std::size_t k = 0; k < names.size(); ++k)
    if (names[k].starts_with("CH")) add_channel(table, k, columns.channels);
  const std::size_t channels = columns.channels.size();
  if (channels == 0)
    table.fail(
        fmt::format("is not a known oscilloscope layout: it names no channel (CH1, ...); {}", kScopeLayouts));
  if (in_row) {
    if (!table.next() || table.filled() < channels + 3)
      table.fail("the second line must hold Sequence, the channels' units, start and increment");
    file.start_s = table.number(table.cells()[channels + 1]);
    file.increment_s = table.number(table.cells()[channels + 2]);
  } else {
    file.start_s = seconds_in(table, stated(names, "t0")).value_or(0);
    file.increment_s = seconds_in(table, stated(names, "tInc")).value_or(0);
  }
  return columns;
}

TraceColumns by_time(const CsvTable& table, ScopeFile& file) {
  TraceColumns columns;
  std::size_t time = 0;
  for (std::size_t k = table.header().size(); k-- > 0;)
    if (means_time(table.heading(k), k)) time = k;
  columns.time = time;
  columns.second = unit_in(table.heading(time), Dimension::time).value_or(1);
  std::vector<Channel>& channels = columns.channels;
  for (std::size_t k = 0; k < table.header().size(); ++k)
    if (k != time) add_channel(table, k, channels);
  if (channels.empty())
    table.fail(fmt::format("names a time and no channel: {}; {}", table.holds(), kScopeLayouts));
  // Siglent names its channels `Volt` or `Value`, and says above which they are.
  const Cells sources = setting(table, "source"), units = setting(table, "vertical units");
  for (std::size_t k = 0; k < channels.size() && sources.size() >= channels.size(); ++k)
    if (!sources[k].empty()) channels[k].name = channel_name(sources[k], k + 1);
  // "V" or "CH1:mV" among the settings.
  for (std::size_t k = 0; k < channels.size() && k < units.size(); ++k)
    channels[k].volt = unit_in(heading_of(units[k].substr(units[k].find(':') + 1)), Dimension::voltage)
                           .value_or(channels[k].volt);
  if (const Cells interval = setting(table, "sample interval"); !interval.empty())  // or "Analog:5.0E-05"
    file.increment_s = table.number_in(interval[0].substr(interval[0].find(':') + 1)).value_or(0);
  return columns;
}

/// Reads the lines above the numbers, and rows of settings among the first.
TraceColumns read_header(CsvTable& table, ScopeFile& file) {
  const Cells& names = table.header();
  if (names.empty()) return tektronix_tds(table, file);
  return names.front() == "X" || !stated(names, "tInc").empty() ? by_settings(table, file)
                                                                : by_time(table, file);
}

constexpr std::size_t kFewestSamples = 100;

double voltage(const CsvTable& table, std::string_view cell) {
  // As PicoScope writes it.
  if (cell.find("\xe2\x88\x9e") != cell.npos || cell.find("nfinity") != cell.npos)
    table.fail(cell, "the signal was beyond the channel's range; record it again with a larger one");
  return table.number(cell);
}

/// Appends the line's values. A line without all of them may stand before the first whole one, as Keysight
/// writes it, and after the last: false.
bool append(const CsvTable& table, const TraceColumns& columns, ScopeFile& file) {
  const Cells& cells = table.cells();
  const std::size_t last = columns.channels.back().column;
  const auto empty = std::ranges::count_if(columns.channels, [&](const Channel& channel) {
    return channel.column >= cells.size() || cells[channel.column].empty();
  });
  if (empty > 0) {
    if (columns.time && last < cells.size() && empty == std::ssize(columns.channels)) return false;
    table.fail(fmt::format("has {} columns where {} belong: {}", table.filled(), last + 1, table.holds()));
  }
  for (std::size_t c = 0; c < columns.channels.size(); ++c)
    file.channels[c].push_back(columns.channels[c].volt * voltage(table, cells[columns.channels[c].column]));
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
void settle_times(const CsvTable& table, const std::vector<double>& times, ScopeFile& file) {
  constexpr double kAgrees = 1e-3;
  if (times.size() < 2) return;
  const double increment = (times.back() - times.front()) / static_cast<double>(times.size() - 1);
  file.start_s = times.front();
  if (!(file.increment_s > 0 && std::abs(increment / file.increment_s - 1) < kAgrees))
    file.increment_s = increment;
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
  const TraceColumns columns = read_header(table, file);
  for (const Channel& channel : columns.channels) file.names.push_back(channel.name);
  file.channels.resize(file.names.size());
  std::vector<double> times;
  bool ended = false;
  for (bool more = columns.at_first_numbers || table.next(); more; more = table.next()) {
    const bool whole = append(table, columns, file);
    if (whole && ended) table.fail("follows a line without values; export one gapless trace");
    ended = !whole && !file.channels.front().empty();
    if (whole && columns.time) times.push_back(columns.second * table.number(table.cells()[*columns.time]));
  }
  if (columns.time) settle_times(table, times, file);
  if (file.channels.front().size() < kFewestSamples)
    table.fail(fmt::format("the trace has {} samples; at least {} are needed", file.channels.front().size(),
                           kFewestSamples));
  if (!(file.increment_s > 0)) table.fail("the time between samples must be greater than 0");
  return file;
}

void add_channels(const ScopeFile& second, ScopeFile& first) {
  const std::size_t samples = first.channels.front().size(), others = second.channels.front().size();
  const double apart = std::abs(second.start_s - first.start_s),
               drift = std::abs(second.increment_s / first.increment_s - 1) * static_cast<double>(samples);
  if (others != samples || apart > 0.5 * first.increment_s || drift > 0.5)
    throw InvalidInput(
        "{}: is not of the same trace as {}: {} samples from {:.6g} s every {:.6g} s, and {} from {:.6g} s "
        "every {:.6g} s; name the files of one acquisition",
        second.input.path.string(), first.input.path.string(), others, second.start_s, second.increment_s,
        samples, first.start_s, first.increment_s);
  first.names.insert(first.names.end(), second.names.begin(), second.names.end());
  first.channels.insert(first.channels.end(), second.channels.begin(), second.channels.end());
}

}  // namespace tribotrack::apps
