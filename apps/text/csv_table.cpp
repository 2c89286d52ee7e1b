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

std::string csv_cell(const std::string& text) {
  if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
  std::string cell = "\"";
  for (const char c : text) cell += c == '"' ? std::string("\"\"") : std::string(1, c);
  return cell + "\"";
}

CsvTable::CsvTable(std::filesystem::path path, std::string text)
    : path_(std::move(path)), text_(std::move(text)) {
  if (text_.starts_with("\xef\xbb\xbf")) text_.erase(0, 3);
  const std::string_view first = std::string_view(text_).substr(0, text_.find('\n'));
  separator_ = first.find(';') != std::string_view::npos ? ';' : ',';
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

double CsvTable::number(std::string_view cell) const {
  std::string with_point;
  std::string_view text = cell;
  if (separator_ == ';' && cell.find(',') != std::string_view::npos) {
    with_point = cell;
    std::replace(with_point.begin(), with_point.end(), ',', '.');
    text = with_point;
  }
  const auto value = parse_number(text);
  if (!value) fail(cell, fmt::format("`{}` is not a number", cell));
  return *value;
}

void CsvTable::fail(const std::string& what) const {
  if (line_ == 0) throw InvalidInput(fmt::format("{}: {}", path_.string(), what));
  throw InvalidInput(fmt::format("{}:{}: {}", path_.string(), line_, what));
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
    const auto to = line.find(separator_, from);
    cells_.push_back(trimmed(line.substr(from, to == line.npos ? to : to - from)));
    if (to == line.npos) return;
    from = to + 1;
  }
}

}  // namespace tribotrack::apps
