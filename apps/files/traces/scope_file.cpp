#include "apps/files/traces/scope_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "apps/files/traces/scope_header.h"
#include "apps/program/errors.h"
#include "apps/text/angle.h"
#include "apps/text/csv_table.h"
#include "apps/text/strict_toml.h"

namespace tribotrack::apps {

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
