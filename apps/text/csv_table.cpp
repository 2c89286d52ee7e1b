#include "apps/text/csv_table.h"

#include <fmt/format.h>

#include <algorithm>

#include "apps/program/errors.h"
#include "apps/text/angle.h"

namespace tribotrack::apps {

namespace {

std::string_view trimmed(std::string_view text) {
  constexpr const char* kAround = " \t\r\"";
  const auto from = text.find_first_not_of(kAround);
  if (from == std::string_view::npos) return text.substr(0, 0);
  return text.substr(from, text.find_last_not_of(kAround) - from + 1);
}

}  // namespace

namespace {

char separator_of(std::string_view text) {
  constexpr int kLinesLookedAt = 5;
  for (int line = 0; line < kLinesLookedAt && !text.empty(); ++line) {
    const std::string_view one = text.substr(0, text.find('\n'));
    text.remove_prefix(std::min(text.size(), one.size() + 1));
    for (const char separator : {';', '\t', ','})
      if (one.find(separator) != std::string_view::npos) return separator;
  }
  return ' ';
}

/// Where a cell that begins here ends: at a separator outside quotes.
std::size_t end_of_cell(std::string_view line, std::size_t from, char separator) {
  const std::size_t first = line.find_first_not_of(" \t", from);
  if (first != std::string_view::npos && line[first] == '"' && separator != '"') {
    std::size_t close = line.find('"', first + 1);
    while (close != std::string_view::npos && close + 1 < line.size() && line[close + 1] == '"')
      close = line.find('"', close + 2);
    if (close != std::string_view::npos) {
      const std::size_t next = line.find(separator, close + 1);
      const std::string_view between =
          line.substr(close + 1, next == std::string_view::npos ? next : next - close - 1);
      if (trimmed(between).empty()) return next;
    }
  }
  return line.find(separator, from);
}

}  // namespace

std::string csv_cell(const std::string& text) {
  if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
  std::string cell = "\"";
  for (const char c : text) cell += c == '"' ? std::string("\"\"") : std::string(1, c);
  return cell + "\"";
}

CsvTable::CsvTable(std::filesystem::path path, std::string text)
    : path_(std::move(path)), text_(std::move(text)) {
  if (text_.starts_with("\xef\xbb\xbf")) text_.erase(0, 3);
  separator_ = separator_of(text_);
}

bool CsvTable::next() {
  while (place_ < text_.size()) {
    const auto end = std::min(text_.find('\n', place_), text_.size());
    line_text_ = std::string_view(text_).substr(place_, end - place_);
    place_ = end + 1;
    ++line_;
    if (trimmed(line_text_).empty()) continue;
    split(line_text_);
    return true;
  }
  return false;
}

std::size_t CsvTable::filled() const {
  std::size_t count = cells_.size();
  while (count > 0 && cells_[count - 1].empty()) --count;
  return count;
}

std::string CsvTable::place() const {
  return line_ == 0 ? path_.string() : fmt::format("{}:{}", path_.string(), line_);
}

std::string CsvTable::with_point(std::string_view cell) const {
  std::string text(cell);
  if (separator_ != ',') std::replace(text.begin(), text.end(), ',', '.');
  return text;
}

double CsvTable::number(std::string_view cell) const {
  const bool comma = separator_ != ',' && cell.find(',') != std::string_view::npos;
  const auto value = comma ? parse_number(with_point(cell)) : parse_number(cell);
  if (!value) fail(cell, fmt::format("`{}` is not a number", cell));
  return *value;
}

void CsvTable::fail(const std::string& what) const {
  throw InvalidInput(fmt::format("{}: {}", place(), what));
}

void CsvTable::fail(std::string_view cell, const std::string& what) const {
  const char* begin = line_text_.data();
  if (cell.data() < begin || cell.data() > begin + line_text_.size()) fail(what);
  throw InvalidInput(fmt::format("{}:{}:{}: {}", path_.string(), line_, cell.data() - begin + 1, what));
}

void CsvTable::split(std::string_view line) {
  cells_.clear();
  std::size_t from = 0;
  while (true) {
    if (separator_ == ' ') from = std::min(line.find_first_not_of(" \r", from), line.size());
    const auto to = end_of_cell(line, from, separator_);
    cells_.push_back(trimmed(line.substr(from, to == line.npos ? to : to - from)));
    if (to == line.npos) return;
    from = to + 1;
    if (separator_ == ' ' && trimmed(line.substr(from)).empty()) return;
  }
}

}  // namespace tribotrack::apps
