#include "apps/files/scope_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>

#include "apps/program/errors.h"
#include "apps/text/strict_toml.h"

namespace tribotrack::apps {

namespace {

using Fields = std::vector<std::string>;

std::string trimmed(std::string_view text) {
  const auto from = text.find_first_not_of(" \t\r\"");
  if (from == std::string_view::npos) return "";
  return std::string(text.substr(from, text.find_last_not_of(" \t\r\"") - from + 1));
}

/// The file's lines as fields, and where each stands.
class Table {
 public:
  Table(const std::filesystem::path& path, std::string text) : path_(path), text_(std::move(text)) {
    if (text_.rfind("\xef\xbb\xbf", 0) == 0) text_.erase(0, 3);
    separator_ = text_.substr(0, text_.find('\n')).find(';') != std::string::npos ? ';' : ',';
  }
  /// The next line that is not empty; false at the end.
  bool next(Fields& fields) {
    while (place_ < text_.size()) {
      const auto end = std::min(text_.find('\n', place_), text_.size());
      const std::string_view line = std::string_view(text_).substr(place_, end - place_);
      place_ = end + 1;
      ++line_;
      if (trimmed(line).empty()) continue;
      split(line, fields);
      return true;
    }
    return false;
  }
  double number(const std::string& field) const {
    std::string text = field;
    if (separator_ == ';') std::replace(text.begin(), text.end(), ',', '.');
    double value = 0;
    const char* begin = text.data() + (text.rfind('+', 0) == 0);
    const auto [end, error] = std::from_chars(begin, text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value))
      fail(fmt::format("`{}` is not a number", field));
    return value;
  }
  [[noreturn]] void fail(const std::string& what) const {
    throw InvalidInput(fmt::format("{}:{}: {}", path_.string(), line_, what));
  }

 private:
  void split(std::string_view line, Fields& fields) const {
    fields.clear();
    std::size_t from = 0;
    while (true) {
      const auto to = line.find(separator_, from);
      fields.push_back(trimmed(line.substr(from, to == line.npos ? to : to - from)));
      if (to == line.npos) break;
      from = to + 1;
    }
    while (!fields.empty() && fields.back().empty()) fields.pop_back();  // a separator ends the line
  }

  std::filesystem::path path_;
  std::string text_;
  char separator_ = ',';
  std::size_t place_ = 0;
  int line_ = 0;
};

/// "CH2(V)" -> "CH2", "X(CH1)" -> "CH1".
std::string channel_name(const std::string& header) {
  const auto at = header.find("CH");
  if (at == std::string::npos) return "";
  auto end = at + 2;
  while (end < header.size() && header[end] >= '0' && header[end] <= '9') ++end;
  return header.substr(at, end - at);
}

/// The number after "t0 =" or "tInc =", with or without its unit s.
std::optional<double> stated(const Table& table, const Fields& header, const std::string& name) {
  for (const std::string& field : header) {
    if (field.rfind(name, 0) != 0) continue;
    std::string value = field.substr(std::min(field.size(), field.find('=') + 1));
    if (!value.empty() && value.back() == 's') value.pop_back();
    return table.number(trimmed(value));
  }
  return std::nullopt;
}

void append(const Table& table, ScopeFile& file, const Fields& fields, std::size_t first) {
  if (fields.size() < first + file.names.size())
    table.fail(fmt::format("has {} columns where {} belong", fields.size(), first + file.names.size()));
  for (std::size_t c = 0; c < file.names.size(); ++c)
    file.channels[c].push_back(table.number(fields[first + c]));
}

/// `X,CH1,...,Start,Increment` and under it `Sequence,Volt,...,start,increment`.
void read_ds1000z(Table& table, ScopeFile& file, Fields& fields) {
  file.layout = "Rigol DS1000Z";
  const std::size_t channels = file.names.size();
  if (!table.next(fields) || fields.size() < channels + 3)
    table.fail("the second line must hold Sequence, the channels' units, start and increment");
  file.start_s = table.number(fields[channels + 1]);
  file.increment_s = table.number(fields[channels + 2]);
  while (table.next(fields)) append(table, file, fields, 1);
}

/// A time column and values; the times' ends give start and increment.
void read_with_times(Table& table, ScopeFile& file, Fields& fields) {
  double last = 0;
  std::size_t rows = 0;
  while (table.next(fields)) {
    if (rows == 0 && !fields.empty() && fields[0] == "Second") continue;  // a line of units
    last = table.number(fields.at(0));
    if (rows == 0) file.start_s = last;
    append(table, file, fields, 1);
    ++rows;
  }
  if (rows > 1) file.increment_s = (last - file.start_s) / static_cast<double>(rows - 1);
}

}  // namespace

ScopeFile read_scope_file(const std::filesystem::path& path) {
  if (!std::filesystem::is_regular_file(path))
    throw InvalidInput(fmt::format("{}: there is no such oscilloscope file; check `scope`", path.string()));
  Table table(path, read_text(path));
  ScopeFile file;
  Fields header, fields;
  if (!table.next(header)) table.fail("the file is empty");
  for (const std::string& field : header)
    if (const std::string name = channel_name(field); !name.empty()) file.names.push_back(name);
  file.channels.resize(file.names.size());
  if (file.names.empty())
    table.fail(
        "is not a known oscilloscope layout: its first line names no channel (CH1, ...); Rigol's DS1000Z, "
        "DS1102E and MSO5000 layouts are read");
  const auto start = stated(table, header, "t0");
  const auto increment = stated(table, header, "tInc");
  if (start && increment) {
    file.layout = "Rigol MSO5000";
    file.start_s = *start;
    file.increment_s = *increment;
    while (table.next(fields)) append(table, file, fields, 0);
  } else if (header[0] == "X" && std::count(header.begin(), header.end(), "Increment") == 1) {
    read_ds1000z(table, file, fields);
  } else if (header[0] == "Time") {
    file.layout = "Rigol DS1102E";
    read_with_times(table, file, fields);
  } else if (header[0] == "Time(s)") {
    file.layout = "Rigol MSO5000";
    read_with_times(table, file, fields);
  } else {
    table.fail(
        "is not a known oscilloscope layout: Rigol's DS1000Z (X,CH1,Start,Increment), DS1102E "
        "(Time,X(CH1)) and MSO5000 (Time(s),CH1(V)) are read");
  }
  if (file.channels.front().size() < 100)
    table.fail(
        fmt::format("the trace has {} samples; at least 100 are needed", file.channels.front().size()));
  if (!(file.increment_s > 0)) table.fail("the time between samples must be greater than 0");
  return file;
}

}  // namespace tribotrack::apps
