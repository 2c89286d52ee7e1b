#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "apps/files/tracks/any_track.h"
#include "apps/program/errors.h"
#include "apps/text/angle.h"

namespace tribotrack::apps {

namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
/// Pixels, millimetres, seconds: nothing that was filmed lies beyond.
constexpr double kBeyondAll = 1e9;

/// Tracker writes "mass A" as mass_A.
bool same_name(const std::string& a, const std::string& b) {
  std::string one = lower(a), other = lower(b);
  for (std::string* text : {&one, &other}) std::replace(text->begin(), text->end(), ' ', '_');
  return one == other;
}

bool is_mark(const std::string& name) {
  return same_name(name, "marker") || same_name(name, "mark");
}

/// The last digit of a number as it is printed: 0.001 for "12.345", 1e-8 for "1.2345E-4".
double last_digit(std::string_view cell) {
  const auto exponent_at = cell.find_first_of("eE");
  const std::string_view mantissa = cell.substr(0, exponent_at);
  const auto point = mantissa.find_first_of(".,");
  const double decimals =
      point == std::string_view::npos ? 0 : static_cast<double>(mantissa.size() - point - 1);
  double exponent = 0;
  if (exponent_at != std::string_view::npos)
    exponent = parse_number(cell.substr(exponent_at + 1)).value_or(0);
  return std::min(std::pow(10, exponent - decimals), kBeyondAll);
}

/// Reads cells of the current line.
class Line {
 public:
  Line(const CsvTable& table, const TrackColumns& columns) : table_(table), columns_(columns) {}

  std::string_view cell(std::size_t column) const {
    return column < table_.cells().size() ? table_.cells()[column] : std::string_view();
  }
  /// NaN for an empty cell or one that says so.
  double number(std::size_t column) const {
    const std::string_view text = cell(column);
    if (CsvTable::is_none(text)) return kNone;
    const double value = table_.number(text);
    if (std::abs(value) > kBeyondAll) table_.fail(text, fmt::format("`{}` is out of range", text));
    return value;
  }
  std::int64_t frame() const {
    const std::string_view text = cell(*columns_.frame);
    const double value = number(*columns_.frame);
    if (!(std::abs(value) <= kBeyondAll) || value != std::floor(value))
      table_.fail(text.empty() ? table_.cells().front() : text,
                  fmt::format("`{}` is no frame's number; it must be a whole number", text));
    return static_cast<std::int64_t>(value);
  }
  double time() const {
    const std::string_view text = cell(*columns_.time);
    if (CsvTable::is_none(text)) table_.fail("has no time");
    return text.find(':') == text.npos ? number(*columns_.time) * columns_.second : time_code(text);
  }

  /// h:mm:ss.fff, or of Kinovea h:mm:ss:cc, whose last are hundredths; of other programs they are frames of a
  /// film.
  double time_code(std::string_view text) const {
    double seconds = 0;
    int parts = 0;
    for (std::size_t from = 0; from <= text.size(); ++parts) {
      const std::size_t to = std::min(text.find(':', from), text.size());
      const double part = table_.number(text.substr(from, to - from));
      if (parts == 3 && !columns_.by_section)
        table_.fail(text,
                    fmt::format("`{}` is a time code that counts frames; export times in s or ms", text));
      seconds = parts == 3 ? seconds + 0.01 * part : 60 * seconds + part;
      from = to + 1;
    }
    if (parts > 4) table_.fail(text, fmt::format("`{}` is no time", text));
    return seconds;
  }
  double time_step() const {
    const std::string_view text = cell(*columns_.time);
    if (std::ranges::count(text, ':') == 3) return 0.01;
    return last_digit(text) * (text.find(':') == text.npos ? columns_.second : 1);
  }

  /// `row`: its frame where the file numbers none.
  PointSample sample(const PointColumns& point, std::int64_t row) const {
    PointSample sample{columns_.frame ? frame() : row};
    if (columns_.time) {
      sample.time = time();
      sample.time_step = time_step();
    }
    sample.x = number(point.x);
    sample.y = number(point.y);
    sample.step = std::max(last_digit(cell(point.x)), last_digit(cell(point.y)));
    const bool failed = columns_.no_sd_is_lost && !(number(*point.x_sd) > 0);
    if (std::isnan(sample.x) || std::isnan(sample.y) || failed) sample.x = sample.y = kNone;
    if (!point.x_sd) return sample;
    for (const auto& [column, sd] : {std::pair(*point.x_sd, &sample.x_sd), {*point.y_sd, &sample.y_sd}}) {
      *sd = number(column);
      if (sample.seen() && !(*sd > 0)) table_.fail(cell(column), "an sd must be greater than 0");
    }
    return sample;
  }

 private:
  const CsvTable& table_;
  const TrackColumns& columns_;
};

PointSamples samples_of(const PointColumns& point, std::string name) {
  return {std::move(name), point.unit, point.x_sd.has_value()};
}

/// Frames and times must increase.
void require_order(const CsvTable& table, const std::vector<PointSample>& samples) {
  if (samples.size() < 2) return;
  const PointSample &last = samples.back(), &before = samples[samples.size() - 2];
  if (last.frame <= before.frame)
    table.fail("its frame does not come after the one above; put the rows in the order of time");
  if (last.time <= before.time)
    table.fail("its time does not come after the one above; put the rows in the order of time");
}

[[noreturn]] void ask_which(const CsvTable& table, const std::vector<std::string>& names) {
  throw InvalidInput(
      "{}: holds {} points: {}; say which is the part, track_point = \"{}\" in the run (--track-point), and, "
      "where one is fixed to the platform, track_mark = \"NAME\"",
      table.path().string(), names.size(), fmt::join(names, ", "), names.front());
}

[[noreturn]] void refuse_name(const CsvTable& table, const char* key, const std::string& name,
                              const std::vector<std::string>& names) {
  throw InvalidInput("{}: there is no point \"{}\" ({}); it holds {}", table.path().string(), name, key,
                     fmt::join(names, ", "));
}

/// Which of these names is the part, and which the mark, if any.
std::pair<std::size_t, std::optional<std::size_t>> choose(const CsvTable& table,
                                                          const std::vector<std::string>& names,
                                                          const TrackReading& reading) {
  const auto named = [&](const char* key, const std::string& name) {
    const auto found = std::ranges::find_if(names, [&](const std::string& n) { return same_name(n, name); });
    if (found == names.end()) refuse_name(table, key, name, names);
    return static_cast<std::size_t>(found - names.begin());
  };
  std::optional<std::size_t> mark;
  if (!reading.mark.empty())
    mark = named("track_mark", reading.mark);
  else if (const auto found = std::ranges::find_if(names, is_mark); found != names.end() && names.size() > 1)
    mark = static_cast<std::size_t>(found - names.begin());
  if (!reading.point.empty()) {
    const std::size_t part = named("track_point", reading.point);
    if (mark && *mark == part)
      throw InvalidInput(
          "{}: \"{}\" is named as part and as mark; the part moves on the platform, the mark with it",
          table.path().string(), names[part]);
    return {part, mark};
  }
  std::vector<std::size_t> others;
  for (std::size_t k = 0; k < names.size(); ++k)
    if (k != mark) others.push_back(k);
  if (others.size() != 1) ask_which(table, names);
  return {others.front(), mark};
}

/// One row a frame, each point in columns of its own.
PartAndMark read_wide(CsvTable& table, const TrackColumns& columns, const TrackReading& reading) {
  std::vector<std::string> names;
  for (const PointColumns& point : columns.points)
    names.push_back(point.name.empty() ? "the part" : point.name);
  const auto [part, mark] = choose(table, names, reading);
  PartAndMark result{samples_of(columns.points[part], columns.points[part].name), std::nullopt};
  if (mark) result.mark = samples_of(columns.points[*mark], columns.points[*mark].name);
  for (std::int64_t row = 0; table.next(); ++row) {
    const Line line(table, columns);
    result.part.at.push_back(line.sample(columns.points[part], row));
    require_order(table, result.part.at);
    if (mark) result.mark->at.push_back(line.sample(columns.points[*mark], row));
  }
  return result;
}

/// Names of blocks of rows, each of another point: the comment that stands above, else their number.
class Blocks {
 public:
  const std::string& name_of(const CsvTable& table, double time) {
    if (count_ == 0 || (table.is_apart() && time <= last_)) {
      const bool named = !table.section().empty() && table.section().data() != section_.data();
      name_ = named ? std::string(table.section()) : fmt::format("{}", count_ + 1);
      section_ = table.section();
      ++count_;
    }
    last_ = time;
    return name_;
  }

 private:
  int count_ = 0;
  double last_ = 0;
  std::string name_;
  std::string_view section_;
};

/// One row for each particle and frame, or a particle's rows after another's.
PartAndMark read_long(CsvTable& table, const TrackColumns& columns, const TrackReading& reading) {
  Blocks blocks;
  std::vector<std::string> names;
  std::vector<std::map<std::int64_t, PointSample>> rows;  // of each particle, by frame
  const PointColumns& point = columns.points.front();
  while (table.next()) {
    const Line line(table, columns);
    std::string name(columns.by_section ? blocks.name_of(table, line.time()) : line.cell(*columns.particle));
    if (name.ends_with(".0")) name.resize(name.size() - 2);  // an integer that pandas made a float
    const auto known = std::ranges::find(names, name);
    const auto k = static_cast<std::size_t>(known - names.begin());
    if (known == names.end()) {
      names.push_back(name);
      rows.emplace_back();
    }
    const PointSample row = line.sample(point, std::ssize(rows[k]));
    if (!rows[k].emplace(row.frame, row).second)
      table.fail(fmt::format("particle {} is in frame {} twice", name, row.frame));
  }
  if (names.empty()) return {samples_of(point, point.name), std::nullopt};
  std::vector<std::string> listed = names;
  constexpr std::size_t kMostListed = 12;
  if (listed.size() > kMostListed) {
    std::vector<std::size_t> order(names.size());
    for (std::size_t k = 0; k < order.size(); ++k) order[k] = k;
    std::ranges::stable_sort(order, std::ranges::greater(), [&](std::size_t k) { return rows[k].size(); });
    listed.clear();
    for (std::size_t k = 0; k < kMostListed; ++k) listed.push_back(names[order[k]]);
  }
  if (reading.point.empty() && names.size() > 1) ask_which(table, listed);
  const auto [part, mark] = choose(table, names, reading);
  PartAndMark result{samples_of(point, names[part]), std::nullopt};
  if (mark) result.mark = samples_of(point, names[*mark]);
  for (const auto& [frame, row] : rows[part]) {
    result.part.at.push_back(row);
    require_order(table, result.part.at);
    if (!mark) continue;
    const auto other = rows[*mark].find(frame);
    result.mark->at.push_back(other == rows[*mark].end() ? PointSample{frame} : other->second);
  }
  return result;
}

}  // namespace

PartAndMark read_points(CsvTable& table, const TrackColumns& columns, const TrackReading& reading) {
  return columns.particle || columns.by_section ? read_long(table, columns, reading)
                                                : read_wide(table, columns, reading);
}

}  // namespace tribotrack::apps
