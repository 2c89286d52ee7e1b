#include "apps/text/csv_table.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <boost/algorithm/string/classification.hpp>
#include <boost/algorithm/string/replace.hpp>
#include <boost/algorithm/string/split.hpp>
#include <boost/locale/encoding_utf.hpp>
#include <charconv>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "apps/program/errors.h"
#include "apps/text/angle.h"
#include "apps/text/input_file.h"

namespace tribotrack::apps {

std::string lower(std::string_view text) {
  std::string kept(text);
  for (char& c : kept)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return kept;
}

std::vector<std::string> parts_of(std::string_view text, char between) {
  std::vector<std::string> parts;
  return boost::split(parts, text, [between](char c) { return c == between; });
}

std::optional<double> parse_number(std::string_view text) {
  if (!text.empty() && text.front() == '+') text.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

std::optional<double> parse_angle(std::string_view text) {
  std::string compact(text);
  std::erase_if(compact, [](char c) { return c == ' ' || c == '\t'; });
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

std::string csv_cell(const std::string& text) {
  const bool comment = text.find_first_of("#%!/") == 0;  // it would be read as one
  if (!comment && text.find_first_of(",\"\n\r") == std::string::npos) return text;
  return "\"" + boost::replace_all_copy(text, "\"", "\"\"") + "\"";
}

std::string cell_text(const Json& value) {
  if (value.is_string()) return value.get<std::string>();
  if (value.is_boolean()) return value.get<bool>() ? "yes" : "no";
  return exact(value.get<double>());
}

std::string csv_of(const std::vector<Json>& rows) {
  std::string csv;
  for (const Json& row : rows) {
    std::vector<std::string> names, cells;
    for (const auto& [name, value] : row.items()) {
      names.push_back(name);
      cells.push_back(csv_cell(cell_text(value)));
    }
    if (csv.empty()) csv = fmt::format("{}\n", fmt::join(names, ","));
    csv += fmt::format("{}\n", fmt::join(cells, ","));
  }
  return csv;
}

std::string csv_of(const Columns& columns, std::string (*number)(double)) {
  std::string csv;
  for (const auto& [name, column] : columns) csv += (csv.empty() ? "" : ",") + name;
  const auto rows = std::visit([](const auto& values) { return values.size(); }, columns.front().second);
  for (std::size_t row = 0; row < rows; ++row) {
    char before = '\n';
    for (const auto& [name, column] : columns) {
      csv += std::exchange(before, ',');
      if (const auto* numbers = std::get_if<std::vector<double>>(&column))
        csv += number((*numbers)[row]);
      else
        csv += std::visit([row](const auto& values) { return fmt::format("{}", values[row]); }, column);
    }
  }
  return csv + "\n";
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

/// Other spellings of a part of a word.
constexpr std::array<std::pair<std::string_view, std::string_view>, 17> kSpellings = {
    {{"\xcf\x86", "phi"},
     {"\xcf\x95", "phi"},
     {"\xce\xb1", "alpha"},
     {"\xce\x94", "d"},
     {"\xce\xb4", "d"},
     {"\xcf\x84", "tau"},
     {"\xcf\x89", "w"},
     {"\xcf\x83", "sigma"},
     {"\xc2\xb0", "deg"},
     {"\xc2\xb5", "u"},
     {"\xce\xbc", "u"},
     {"\xe2\x81\xbb\xc2\xb9", "^-1"},
     {"\xc2\xb7", " "},
     {"\xe2\x8b\x85", " "},
     {"\xef\xbb\xbf", ""},
     {"s^-1", "s"},
     {"s-1", "s"}}};

/// Other spellings of a whole word.
constexpr std::array<std::pair<std::string_view, std::string_view>, 22> kWords = {
    {{"degrees", "deg"}, {"degree", "deg"}, {"radians", "rad"},     {"pixels", "px"},
     {"pixel", "px"},    {"pix", "px"},     {"seconds", "s"},       {"second", "s"},
     {"sec", "s"},       {"msec", "ms"},    {"milliseconds", "ms"}, {"millisecond", "ms"},
     {"volts", "v"},     {"volt", "v"},     {"metres", "m"},        {"meters", "m"},
     {"metre", "m"},     {"meter", "m"},    {"millimeters", "mm"},  {"millimetres", "mm"},
     {"micron", "um"},   {"microns", "um"}}};

std::string plain(std::string_view text) {
  std::string kept = lower(text);
  for (const auto& [from, to] : kSpellings) boost::replace_all(kept, from, to);
  for (int digit = 0; digit < 10; ++digit)  // subscripts
    boost::replace_all(kept, std::string{'\xe2', '\x82', static_cast<char>(0x80 + digit)},
                       fmt::format("_{}", digit));
  return kept;
}

std::vector<std::string> words_of(const std::string& text) {
  std::vector<std::string> words;
  boost::split(words, text, boost::is_any_of(" \t_/.()[]{},:#\"'"));
  std::erase(words, "");
  for (std::string& word : words)
    for (const auto& [from, to] : kWords)
      if (word == from) word = to;
  return words;
}

bool means_sd(const std::string& word) {
  constexpr std::array<std::string_view, 6> all = {"sd", "std", "stdev", "sigma", "uncertainty", "s.d."};
  return std::ranges::find(all, word) != all.end();
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
    const std::string unit = fmt::format("{}", fmt::join(rest.subspan(from), "/"));
    if (std::ranges::find(kUnits, unit, &Unit::name) == kUnits.end()) continue;
    heading.unit = unit;
    until = from;
    if (from > 1 && rest[from - 1] == "in") --until;
  }
  heading.quantity = fmt::format("{}", fmt::join(rest.first(until), "_"));
  return heading;
}

std::optional<double> si_per(std::string_view unit, Dimension dimension) {
  for (const Unit& known : kUnits)
    if (known.name == unit && known.dimension == dimension) return known.si;
  return std::nullopt;
}

namespace {

constexpr std::size_t kMostColumns = 4096;  ///< no table of measurements has more

std::string_view trimmed(std::string_view text, const char* around = " \t\r\"") {
  const auto from = text.find_first_not_of(around);
  if (from == std::string_view::npos) return text.substr(0, 0);
  return text.substr(from, text.find_last_not_of(around) - from + 1);
}

// A text as UTF-8, with `-` for a minus sign and a blank for one of fixed width.

std::string as_utf8(const std::filesystem::path& path, std::string text) {
  if (text.starts_with("PK\x03\x04") || text.starts_with("\xd0\xcf\x11\xe0"))
    throw InvalidInput("{}: is a spreadsheet, not a text; save it as CSV", path.string());
  const bool ascii =
      std::accumulate(text.begin(), text.end(), 0, [](int all, char c) { return all | c; }) >= 0;
  const bool little = text.starts_with("\xff\xfe");
  if (little || text.starts_with("\xfe\xff")) {
    std::u16string units;
    for (std::size_t k = 2; k + 1 < text.size(); k += 2)
      units += static_cast<char16_t>(static_cast<unsigned char>(text[k + little]) << 8 |
                                     static_cast<unsigned char>(text[k + 1 - little]));
    text = boost::locale::conv::utf_to_utf<char>(units);
  }
  if (text.find('\0') != text.npos || text.starts_with('\x80'))
    throw InvalidInput(
        "{}: is no table but a binary file{}", path.string(),
        path.extension() == ".npy" || path.extension() == ".pkl"
            ? ": write one of pyidi's points as text, with d = displacements[point]: "
              "numpy.savetxt(\"x.csv\", numpy.c_[numpy.arange(len(d)), d[:, 1], d[:, 0]], delimiter=\",\", "
              "header=\"frame,x_px,y_px\", comments=\"\")"
            : "; if it is a recording, give it as `video`, or `tribotrack track` makes a track of it");
  if (!ascii && !encoding_slip(text).empty()) {  // Latin-1, whose bytes are the first of Unicode
    const auto* bytes = reinterpret_cast<const unsigned char*>(text.data());
    text = boost::locale::conv::utf_to_utf<char>(std::u16string(bytes, bytes + text.size()));
  }
  for (const auto& [from, to] : {std::pair{"\xef\xbb\xbf", ""},
                                 {"\xe2\x88\x92", "-"},
                                 {"\xc2\xa0", " "},
                                 {"\xe2\x80\xaf", " "},
                                 {"\xe2\x80\x89", " "}})
    if (!ascii) boost::replace_all(text, from, to);
  if (text.find('\n') == text.npos) std::ranges::replace(text, '\r', '\n');
  return text;
}

// Cells.

/// Where a cell that begins here ends: at a separator outside quotes.
std::size_t end_of_cell(std::string_view line, std::size_t from, char separator) {
  const std::size_t first = line.find_first_not_of(" \t", from);
  if (first != std::string_view::npos && line[first] == '"') {
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
  return separator == ' ' ? line.find_first_of(" \t", from) : line.find(separator, from);
}

/// False where there are more than kMostColumns.
bool split(std::string_view line, char separator, Cells& cells) {
  cells.clear();
  for (std::size_t from = 0; cells.size() <= kMostColumns;) {
    if (separator == ' ') from = std::min(line.find_first_not_of(" \t\r", from), line.size());
    const auto to = end_of_cell(line, from, separator);
    cells.push_back(trimmed(line.substr(from, to == line.npos ? to : to - from)));
    if (to == line.npos) return true;
    from = to + 1;
    if (separator == ' ' && trimmed(line.substr(from)).empty()) return true;
  }
  return false;
}

std::size_t filled_in(const Cells& cells) {
  std::size_t count = cells.size();
  while (count > 0 && cells[count - 1].empty()) --count;
  return count;
}

/// "Time (s)" that blanks have separated is one cell.
Cells with_units_joined(const Cells& cells) {
  Cells joined;
  for (const std::string_view cell : cells)
    if (!joined.empty() && (cell.starts_with('(') || cell.starts_with('[')))
      joined.back() = {joined.back().data(),
                       static_cast<std::size_t>(cell.data() + cell.size() - joined.back().data())};
    else
      joined.push_back(cell);
  return joined;
}

bool is_comment(std::string_view line) {
  line = trimmed(line, " \t\r");  // what stands in quotes is a cell
  return (line.starts_with('#') && !line.starts_with("#N/A") && !line.starts_with("#NV")) ||
         line.starts_with('%') || line.starts_with('!') || line.starts_with("//") ||
         (line.starts_with("sep=") && line.size() == 5);
}

std::optional<double> number_of(std::string_view cell, char decimal) {
  if (decimal == '.') return parse_number(cell);
  if (cell.find('.') != cell.npos) return std::nullopt;
  std::string text(cell);
  std::ranges::replace(text, decimal, '.');
  return parse_number(text);
}

/// "(ms)", "volt": a unit and nothing else; empty where it is none that is known.
std::string unit_alone(std::string_view cell) {
  const Heading heading = heading_of("x " + std::string(cell));  // a unit by itself is no first word
  return heading.quantity == "x" ? heading.unit : "";
}

std::string short_text(std::string_view text) {
  constexpr std::size_t kLongest = 60;
  return std::string(text.substr(0, kLongest)) + (text.size() > kLongest ? "..." : "");
}

}  // namespace

bool CsvTable::is_none(std::string_view cell) {
  constexpr std::array<std::string_view, 9> all = {"", "nan", "na", "n/a", "#n/a", "#nv", "-", "--", "none"};
  return cell.size() <= 4 && std::ranges::find(all, lower(cell)) != all.end();
}

CsvTable::CsvTable(std::filesystem::path path, std::string text, const Known& known)
    : path_(std::move(path)), text_(as_utf8(path_, std::move(text))) {
  find_form();
  find_header(known);
}

/// The next line that is not empty.
std::optional<CsvTable::Line> CsvTable::line_at(std::size_t& place, int& number) const {
  while (place < text_.size()) {
    const auto end = std::min(text_.find('\n', place), text_.size());
    const std::string_view text = std::string_view(text_).substr(place, end - place);
    place = end + 1;
    ++number;
    if (!trimmed(text).empty()) return Line{text, number, is_comment(text)};
  }
  return std::nullopt;
}

namespace {

/// A number or an angle, its unit perhaps with it.
bool is_value(std::string_view cell, char decimal) {
  for (const std::string_view unit : {"deg", "\u00b0", "rad"})
    if (cell.ends_with(unit)) {
      cell.remove_suffix(unit.size());
      return number_of(cell.substr(0, cell.find_last_not_of(' ') + 1), decimal).has_value();
    }
  return number_of(cell, decimal) || (cell.find("pi") != cell.npos && parse_angle(cell));
}

}  // namespace

/// Numbers and angles in a line, less the cells that are neither: what its form makes of it.
int CsvTable::sense(std::string_view line, const Form& form, Cells& cells) const {
  split(line, form.separator, cells);
  int sense = 0;
  for (const std::string_view cell : cells) {
    if (is_none(cell)) continue;
    sense += is_value(cell, form.decimal) ? 1 : -1;
  }
  return sense;
}

void CsvTable::find_form() {
  constexpr std::array kForms = {Form{';', '.'}, Form{';', ','}, Form{'\t', '.'}, Form{'\t', ','},
                                 Form{',', '.'}, Form{',', ','}, Form{' ', '.'},  Form{' ', ','}};
  constexpr std::size_t kLinesLookedAt = 400, kSmall = 1 << 16;  // of a large text lines all over it
  const std::size_t every = text_.size() < kSmall ? 0 : text_.size() / kLinesLookedAt;
  std::vector<std::string_view> lines;
  int number = 0;
  for (std::size_t place = 0; const auto line = line_at(place, number);) {
    if (!line->comment) lines.push_back(line->text);
    if (every > 0) place = std::min(text_.find('\n', place + every), text_.size());
  }
  Cells cells;
  int best = 0;
  for (const Form& form : kForms) {
    int sum = 0;
    for (const std::string_view line : lines) sum += std::max(0, sense(line, form, cells));
    if (sum <= best) continue;
    best = sum;
    form_ = form;
  }
  if (best == 0) {  // no numbers: of the first line that is separated
    form_.separator = ' ';
    for (const std::string_view line : lines)
      for (const char separator : {';', '\t', ','})
        if (form_.separator == ' ' && line.find(separator) != line.npos) form_.separator = separator;
    int commas = 0;  // few numbers among texts: what most of them are written with
    for (const std::string_view line : lines) {
      split(line, form_.separator, cells);
      for (const std::string_view cell : cells) commas += is_value(cell, ',') - is_value(cell, '.');
    }
    if (commas > 0) form_.decimal = ',';
    return;
  }
  std::map<std::size_t, int> sizes;
  std::map<std::size_t, std::vector<int>> numbers;  // of lines so long, in each column
  for (const std::string_view line : lines) {
    if (sense(line, form_, cells) <= 0) continue;
    cells.resize(filled_in(cells));
    ++sizes[cells.size()];
    std::vector<int>& count = numbers[cells.size()];
    count.resize(cells.size());
    for (std::size_t k = 0; k < cells.size(); ++k) count[k] += number_in(cells[k]).has_value();
  }
  columns_ = std::ranges::max_element(sizes, {}, [](const auto& size) {
               return std::pair(size.second, size.first);
             })->first;
  const auto often = [&](int count) { return 2 * count > sizes[columns_]; };
  const std::vector<int>& of_most = numbers[columns_];
  first_number_ = static_cast<std::size_t>(std::ranges::find_if(of_most, often) - of_most.begin());
}

bool CsvTable::begins_with_number(const Cells& cells) const {
  return columns_ > 0 && first_number_ < cells.size() && number_in(cells[first_number_]);
}

/// Names may be separated otherwise than the numbers below them: then as many as there are columns tell.
Cells CsvTable::names_in(const Line& line) const {
  std::string_view text = line.text;
  if (line.comment) text.remove_prefix(std::min(text.find_first_not_of(" \t\"#%!/"), text.size()));
  Cells own;
  for (const char separator : {form_.separator, ';', '\t', ',', ' '}) {
    Cells cells;
    split(text, separator, cells);
    if (separator == ' ') cells = with_units_joined(cells);
    if (cells.size() == columns_ || filled_in(cells) == columns_) return cells;
    if (own.empty()) own = std::move(cells);
    if (own.size() > 1 && form_.separator != ' ') break;
  }
  return own;
}

void CsvTable::find_header(const Known& known) {
  constexpr int kRows = 20, kLongestPreamble = 10'000;  // rows of numbers, and lines without: no header below
  std::vector<Line> lines;
  std::optional<std::size_t> best, last;  // last: the line above the rows
  std::array<int, 3> rank{};
  Cells cells;
  std::size_t place = 0;
  int number = 0, rows = 0;
  while (rows < kRows && lines.size() < kLongestPreamble) {
    const auto line = line_at(place, number);
    if (!line) break;
    if (!line->comment) {
      split(line->text, form_.separator, cells);
      if (begins_with_number(cells)) {
        if (rows++ == 0) first_row_ = number;
        continue;
      }
      rows = 0;
    }
    lines.push_back(*line);
    if (!line->comment || !last) last = lines.size() - 1;
    const Cells names = names_in(*line);
    const int count = known(names);
    const std::array<int, 3> of_line = {!line->comment, count, filled_in(names) == columns_};
    if (count == 0 || (best && of_line <= rank)) continue;
    best = lines.size() - 1;
    rank = of_line;
    place_ = place;
    line_ = number;
  }
  if (!best) {
    if (last) above_header_ = names_in(lines[*last]);
    return;
  }
  header_ = names_in(lines[*best]);
  header_line_ = line_;
  header_text_ = lines[*best].text;
  if (*best > 0 && !lines[*best - 1].comment) above_header_ = names_in(lines[*best - 1]);
  for (std::size_t k = 0; k <= *best; ++k) {
    above_.push_back(names_in(lines[k]));
    if (lines[k].comment) remarks_ += lines[k].text;
  }
  skip_head(known);
  fit_header();
}

/// Names above the rows, one for each column.
void CsvTable::fit_header() {
  std::size_t place = place_;
  int number = line_;
  const auto row = line_at(place, number);
  const std::size_t names = filled_in(header_);
  // R names the columns, and not the first one of every row, its name in quotes.
  if (row && row->text.starts_with('"') && names + 1 == columns_)
    header_.insert(header_.begin(), header_text_.substr(0, 0));
  if (form_.separator == ' ' && names > columns_ && columns_ > 0)
    fail(fmt::format("has {} names above {} columns: separate them by tabs or commas where they hold blanks",
                     names, columns_));
}

/// What stands between the names and the first row: units, other names for the same columns.
void CsvTable::skip_head(const Known& known) {
  std::size_t place = place_;
  int number = line_;
  Cells cells;
  while (const auto line = line_at(place, number)) {
    if (!line->comment) split(line->text, form_.separator, cells);
    if (!line->comment && begins_with_number(cells)) return;
    const Cells names = names_in(*line);
    if (!take_units(names) && !line->comment && known(names) < 2) return;
    if (line->comment) {
      remarks_ += line->text;
      section_ = trimmed(line->text, " \t\r\"#%!/");
    }
    above_.push_back(names);
    place_ = place;
    line_ = number;
  }
}

bool CsvTable::take_units(const Cells& cells) {
  std::vector<std::string> units;
  bool any = false;
  for (const std::string_view cell : cells) {
    units.push_back(unit_alone(cell));
    any |= !units.back().empty();
    if (units.back().empty() && !cell.empty() && !cell.starts_with('(') && !cell.starts_with('['))
      return false;
  }
  if (any) units_ = std::move(units);
  return any;
}

Heading CsvTable::heading(std::size_t column) const {
  Heading heading = heading_of(header_[column]);
  if (heading.unit.empty() && column < units_.size()) heading.unit = units_[column];
  return heading;
}

bool CsvTable::is_remarked(std::string_view word) const {
  return remarks_.find(word) != std::string::npos;
}

bool CsvTable::next() {
  const int above = line_;
  while (const auto line = line_at(place_, line_)) {
    if (line->comment) {
      section_ = trimmed(line->text, " \t\r\"#%!/");
      continue;
    }
    line_text_ = line->text;
    apart_ = line_ > above + 1;
    if (!split(line_text_, form_.separator, cells_))
      fail(fmt::format("has more than {} columns, which no table of measurements has; check the file",
                       kMostColumns));
    if (!header_.empty() && filled() > header_.size())
      fail(cells_[header_.size()], fmt::format("has {} cells under {} columns; is a decimal comma among "
                                               "them? then separate the cells by semicolons",
                                               filled(), header_.size()));
    return true;
  }
  return false;
}

std::size_t CsvTable::filled() const {
  return filled_in(cells_);
}

std::string CsvTable::place() const {
  const int line = line_text_.empty() ? header_line_ : line_;
  return line == 0 ? path_.string() : fmt::format("{}:{}", path_.string(), line);
}

std::string CsvTable::holds() const {
  std::size_t place = 0;
  int number = 0;
  const auto first = line_at(place, number);
  if (!first) return "it is empty";
  if (columns_ == 0)
    return fmt::format("it holds no rows of numbers, and begins with `{}`", short_text(trimmed(first->text)));
  const char* separator = form_.separator == ';'    ? "semicolons"
                          : form_.separator == '\t' ? "tabs"
                          : form_.separator == ','  ? "commas"
                                                    : "blanks";
  constexpr std::size_t kMostNamed = 12;
  std::string names;
  Cells above = header_.empty() ? above_header_ : header_;
  if (above.size() > kMostNamed) above.resize(kMostNamed);
  for (const std::string_view cell : above)
    if (!cell.empty()) names += fmt::format("{}`{}`", names.empty() ? " under " : ", ", short_text(cell));
  return fmt::format("it holds rows of {} columns from line {} on, separated by {}, with decimal {}{}",
                     columns_, first_row_, separator, form_.decimal == ',' ? "commas" : "points", names);
}

std::optional<double> CsvTable::number_in(std::string_view cell) const {
  return number_of(cell, form_.decimal);
}

std::string CsvTable::with_point(std::string_view cell) const {
  std::string text(cell);
  if (form_.decimal == ',') std::ranges::replace(text, ',', '.');
  return text;
}

double CsvTable::number(std::string_view cell) const {
  const auto value = number_in(cell);
  if (value) return *value;
  std::string plain(cell);
  std::erase_if(plain, [&](char c) { return c == (form_.decimal == ',' ? '.' : ','); });
  const bool other = number_of(plain, form_.decimal).has_value();
  fail(cell, fmt::format("`{}` is not a number{}", short_text(cell),
                         !other ? ""
                         : form_.decimal == ','
                             ? ": this table has decimal commas; write thousands without points"
                             : ": this table has decimal points; write thousands without commas"));
}

void CsvTable::fail(const std::string& what) const {
  throw InvalidInput("{}: {}", place(), what);
}

void CsvTable::fail(std::string_view cell, const std::string& what) const {
  for (const auto& [text, line] : {std::pair(line_text_, line_), std::pair(header_text_, header_line_)})
    if (!text.empty() && cell.data() >= text.data() && cell.data() <= text.data() + text.size())
      throw InvalidInput("{}:{}:{}: {}", path_.string(), line, cell.data() - text.data() + 1, what);
  fail(what);
}

}  // namespace tribotrack::apps
