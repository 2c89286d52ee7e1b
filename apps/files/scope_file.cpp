#include "apps/files/scope_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string_view>
#include <utility>

#include "apps/program/errors.h"
#include "apps/text/csv_table.h"
#include "apps/text/strict_toml.h"

namespace tribotrack::apps {

namespace {

constexpr const char* kLayouts =
    "Rigol's DS1000Z (X,CH1,Start,Increment), DS1102E (Time,X(CH1)) and MSO5000 layouts are read, and of any "
    "other "
    "oscilloscope a plain table in seconds and volts under the line Time(s),CH1(V),CH2(V)";

using Cells = std::vector<std::string_view>;

/// "CH2(V)" -> "CH2", "X(CH1)" -> "CH1".
std::string channel_name(std::string_view header) {
  const auto at = header.find("CH");
  if (at == std::string_view::npos) return "";
  auto end = at + 2;
  while (end < header.size() && header[end] >= '0' && header[end] <= '9') ++end;
  return std::string(header.substr(at, end - at));
}

/// The number after "t0 =" or "tInc =", with or without its unit s.
std::optional<double> stated(const CsvTable& table, const Cells& header, std::string_view name) {
  for (const std::string_view cell : header) {
    if (!cell.starts_with(name)) continue;
    std::string_view value = cell.substr(std::min(cell.size(), cell.find('=') + 1));
    if (value.ends_with('s')) value.remove_suffix(1);
    while (value.starts_with(' ')) value.remove_prefix(1);
    while (value.ends_with(' ')) value.remove_suffix(1);
    return table.number(value);
  }
  return std::nullopt;
}

void append(const CsvTable& table, ScopeFile& file, std::size_t first) {
  if (table.filled() < first + file.names.size())
    table.fail(fmt::format("has {} columns where {} belong", table.filled(), first + file.names.size()));
  for (std::size_t c = 0; c < file.names.size(); ++c)
    file.channels[c].push_back(table.number(table.cells()[first + c]));
}

/// `X,CH1,...,Start,Increment` and under it `Sequence,Volt,...,start,increment`.
void read_ds1000z(CsvTable& table, ScopeFile& file) {
  file.layout = "Rigol DS1000Z";
  const std::size_t channels = file.names.size();
  if (!table.next() || table.filled() < channels + 3)
    table.fail("the second line must hold Sequence, the channels' units, start and increment");
  file.start_s = table.number(table.cells()[channels + 1]);
  file.increment_s = table.number(table.cells()[channels + 2]);
  while (table.next()) append(table, file, 1);
}

/// A time column and values; the times' ends give start and increment.
void read_with_times(CsvTable& table, ScopeFile& file) {
  double last = 0;
  std::size_t rows = 0;
  while (table.next()) {
    if (rows == 0 && table.cells()[0] == "Second") continue;  // a line of units
    last = table.number(table.cells()[0]);
    if (rows == 0) file.start_s = last;
    append(table, file, 1);
    ++rows;
  }
  if (rows > 1) file.increment_s = (last - file.start_s) / static_cast<double>(rows - 1);
}

}  // namespace

ScopeFile read_scope_file(const std::filesystem::path& path) {
  if (!std::filesystem::is_regular_file(path))
    throw InvalidInput(fmt::format("{}: there is no such oscilloscope file; check `scope`", path.string()));
  std::string text = read_text(path);
  ScopeFile file;
  file.input = hashed_input(path, text);
  CsvTable table(path, std::move(text));
  if (!table.next()) table.fail("the file is empty; export the trace again");
  const Cells header(table.cells().begin(), table.cells().begin() + static_cast<long>(table.filled()));
  for (const std::string_view cell : header)
    if (const std::string name = channel_name(cell); !name.empty()) file.names.push_back(name);
  file.channels.resize(file.names.size());
  if (file.names.empty())
    table.fail(fmt::format(
        "is not a known oscilloscope layout: its first line names no channel (CH1, ...); {}", kLayouts));
  const auto start = stated(table, header, "t0");
  const auto increment = stated(table, header, "tInc");
  if (start && increment) {
    file.layout = "Rigol MSO5000";
    file.start_s = *start;
    file.increment_s = *increment;
    while (table.next()) append(table, file, 0);
  } else if (header[0] == "X" && std::count(header.begin(), header.end(), "Increment") == 1) {
    read_ds1000z(table, file);
  } else if (header[0] == "Time") {
    file.layout = "Rigol DS1102E";
    read_with_times(table, file);
  } else if (header[0] == "Time(s)") {
    file.layout = "Rigol MSO5000";
    read_with_times(table, file);
  } else {
    table.fail(fmt::format("is not a known oscilloscope layout; {}", kLayouts));
  }
  if (file.channels.front().size() < 100)
    table.fail(
        fmt::format("the trace has {} samples; at least 100 are needed", file.channels.front().size()));
  if (!(file.increment_s > 0)) table.fail("the time between samples must be greater than 0");
  return file;
}

}  // namespace tribotrack::apps
