#include "apps/text/csv_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <numbers>
#include <span>
#include <utility>
#include <vector>

#include "apps/program/errors.h"
#include "apps/text/angle.h"

namespace tribotrack::apps {

namespace {

std::string without_spaces(std::string_view text) {
  std::string kept;
  for (const char c : text)
    if (c != ' ' && c != '\t') kept += c;
  return kept;
}

}  // namespace

std::optional<double> parse_number(std::string_view text) {
  if (!text.empty() && text.front() == '+') text.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

std::optional<double> parse_angle(std::string_view text) {
  const std::string compact = without_spaces(text);
  if (compact.ends_with("deg")) {
    const auto degrees = parse_number(std::string_view(compact).substr(0, compact.size() - 3));
    return degrees ? std::optional(*degrees * std::numbers::pi / 180) : std::nullopt;
  }
  const auto pi_at = compact.find("pi");
  if (pi_at == std::string::npos) return parse_number(compact);

  std::string factor = compact.substr(0, pi_at);
  std::string divisor = compact.substr(pi_at + 2);
  if (!factor.empty() && factor.back() == '*') {
    factor.pop_back();
    if (factor.empty()) return std::nullopt;
  }
  double value = std::numbers::pi;
  if (factor == "-") {
    value = -value;
  } else if (!factor.empty() && factor != "+") {
    const auto number = parse_number(factor);
    if (!number) return std::nullopt;
    value *= *number;
  }
  if (divisor.empty()) return value;
  if (divisor.front() != '/') return std::nullopt;
  const auto number = parse_number(std::string_view(divisor).substr(1));
  if (!number || *number == 0) return std::nullopt;
  return value / *number;
}

std::string angle_slip(double radians) {
  if (std::abs(radians) <= 4 * std::numbers::pi) return "";
  return fmt::format("must lie within two turns (4 pi rad), not {}: degrees? write \"{}deg\"", radians,
                     radians);
}

namespace {

std::string_view trimmed(std::string_view text) {
  constexpr const char* kAround = " \t\r\"";
  const auto from = text.find_first_not_of(kAround);
  if (from == std::string_view::npos) return text.substr(0, 0);
  return text.substr(from, text.find_last_not_of(kAround) - from + 1);
}

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

namespace {

struct Unit {
  std::string_view name;
  Dimension dimension;
  double si;
};

constexpr double kDegree = std::numbers::pi / 180;

constexpr std::array kUnits = {
    Unit{"rad", Dimension::angle, 1},        Unit{"deg", Dimension::angle, kDegree},
    Unit{"m", Dimension::length, 1},         Unit{"cm", Dimension::length, 1e-2},
    Unit{"mm", Dimension::length, 1e-3},     Unit{"um", Dimension::length, 1e-6},
    Unit{"px", Dimension::pixels, 1},        Unit{"s", Dimension::time, 1},
    Unit{"ms", Dimension::time, 1e-3},       Unit{"us", Dimension::time, 1e-6},
    Unit{"ns", Dimension::time, 1e-9},       Unit{"m/s", Dimension::velocity, 1},
    Unit{"cm/s", Dimension::velocity, 1e-2}, Unit{"mm/s", Dimension::velocity, 1e-3},
    Unit{"um/s", Dimension::velocity, 1e-6}, Unit{"rad/s", Dimension::angular_frequency, 1},
    Unit{"hz", Dimension::frequency, 1},     Unit{"v", Dimension::voltage, 1},
    Unit{"mv", Dimension::voltage, 1e-3},    Unit{"uv", Dimension::voltage, 1e-6}};

/// Other spellings, of a word or of a part of one.
constexpr std::array<std::pair<std::string_view, std::string_view>, 26> kSpellings = {
    {{"\xcf\x86", "phi"}, {"\xcf\x95", "phi"},   {"\xce\xb1", "alpha"}, {"\xce\x94", "d"},
     {"\xce\xb4", "d"},   {"\xcf\x84", "tau"},   {"\xcf\x89", "w"},     {"\xcf\x83", "sigma"},
     {"\xc2\xb0", "deg"}, {"\xc2\xb5", "u"},     {"\xce\xbc", "u"},     {"\xe2\x81\xbb\xc2\xb9", "^-1"},
     {"\xc2\xb7", " "},   {"\xe2\x8b\x85", " "}, {"\xef\xbb\xbf", ""},  {"s^-1", "s"},
     {"s-1", "s"},        {"degrees", "deg"},    {"degree", "deg"},     {"radians", "rad"},
     {"pixels", "px"},    {"pixel", "px"},       {"seconds", "s"},      {"second", "s"},
     {"volts", "v"},      {"volt", "v"}}};

std::string plain(std::string_view text) {
  std::string kept(text);
  for (char& c : kept)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  for (const auto& [from, to] : kSpellings)
    for (auto at = kept.find(from); at != std::string::npos; at = kept.find(from, at + to.size()))
      kept.replace(at, from.size(), to);
  return kept;
}

std::vector<std::string> words_of(const std::string& text) {
  constexpr std::string_view kBetween = " \t_/.()[]{},:\"'";
  std::vector<std::string> words(1);
  for (const char c : text) {
    if (kBetween.find(c) == std::string_view::npos)
      words.back() += c;
    else if (!words.back().empty())
      words.emplace_back();
  }
  if (words.back().empty()) words.pop_back();
  return words;
}

bool means_sd(const std::string& word) {
  constexpr std::array<std::string_view, 6> all = {"sd", "std", "stdev", "sigma", "uncertainty", "s.d."};
  return std::ranges::find(all, word) != all.end();
}

std::string joined(std::span<const std::string> words, char between) {
  std::string text;
  for (const std::string& word : words) {
    if (!text.empty()) text += between;
    text += word;
  }
  return text;
}

}  // namespace

Heading heading_of(std::string_view text) {
  Heading heading;
  std::vector<std::string> words = words_of(plain(text));
  const std::size_t all = words.size();
  std::erase_if(words, means_sd);
  heading.sd = words.size() < all;
  const std::span<const std::string> rest(words);
  std::size_t until = rest.size();
  for (std::size_t from = 1; from < rest.size() && heading.unit.empty(); ++from) {
    const std::string unit = joined(rest.subspan(from), '/');
    if (std::ranges::find(kUnits, unit, &Unit::name) == kUnits.end()) continue;
    heading.unit = unit;
    until = from;
  }
  heading.quantity = joined(rest.first(until), '_');
  return heading;
}

std::optional<double> si_per(std::string_view unit, Dimension dimension) {
  for (const Unit& known : kUnits)
    if (known.name == unit && known.dimension == dimension) return known.si;
  return std::nullopt;
}

}  // namespace tribotrack::apps
