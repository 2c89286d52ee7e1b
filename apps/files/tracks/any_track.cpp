#include "apps/files/tracks/any_track.h"

#include <algorithm>
#include <regex>
#include <utility>

#include "apps/program/errors.h"
#include "apps/text/csv_table.h"
#include "apps/text/output_file.h"
#include "apps/text/strict_toml.h"

namespace tribotrack::apps {

namespace fs = std::filesystem;

namespace {

fs::path meta_of(const fs::path& path) {
  return path.string() + ".meta.json";
}

bool is_ours(const fs::path& path, const std::string& text) {
  const std::string_view first = std::string_view(text).substr(0, text.find('\n'));
  return fs::exists(meta_of(path)) ||
         (first.find("time_s") != first.npos && first.find("status") != first.npos);
}

/// A folder, or nothing at all, is refused as a track of ours is.
std::string text_of_track(const fs::path& path) {
  if (!fs::is_regular_file(path)) read_track_file(path);
  return read_text(path);
}

}  // namespace

Track read_any_track(const fs::path& path, const TrackReading& reading) {
  std::string text = text_of_track(path);
  if (is_ours(path, text)) return read_track_file(path);
  const ForeignTrack foreign = read_foreign_track(path, std::move(text), reading);
  Track track = with_rows(track_described_by(foreign.meta.json(), path), foreign.rows, path);
  track.inputs = foreign.meta.inputs;
  return track;
}

Track import_track(const fs::path& path, const TrackReading& reading, const fs::path& csv) {
  std::string text = text_of_track(path);
  if (!is_ours(path, text)) {
    const ForeignTrack foreign = read_foreign_track(path, std::move(text), reading);
    write_result(csv, track_csv(foreign.rows), foreign.meta);
    return read_track_file(csv);
  }
  Track track = read_track_file(path);  // first: what cannot be read is not copied
  write_file(csv, text);
  if (fs::exists(meta_of(path)))
    write_file(meta_of(csv), read_text(meta_of(path)));
  else
    fs::remove(meta_of(csv));
  track.inputs = {hashed_input(csv, text)};
  return track;
}

namespace {

constexpr const char* kTrackLayouts =
    "tracks of Tracker (t, x, y), Kinovea (Time (ms), ... X, ... Y), DLTdv (pt1_cam1_X), trackpy (frame, x, "
    "y, particle), TrackMate, ImageJ, DICe and tribotrack are read, and of any other program a table with "
    "the columns t_s, x_mm, y_mm";

constexpr std::size_t kNowhere = static_cast<std::size_t>(-1);

bool is_one_of(std::string_view word, std::initializer_list<std::string_view> words) {
  return std::ranges::find(words, word) != words.end();
}

/// "trajectory_1_x", "x_trajectory_1", "position_x", "x1" -> 'x' and "trajectory_1", "", "1"; no axis: 0.
std::pair<char, std::string> axis_of(std::string quantity) {
  const auto is_axis = [](char c) { return c == 'x' || c == 'y'; };
  std::ranges::replace(quantity, '-', '_');
  if (quantity.empty()) return {0, ""};
  std::string name;
  char axis = 0;
  if (quantity.size() == 1 || quantity.find_first_not_of("0123456789", 1) == quantity.npos) {
    if (is_axis(quantity[0])) return {quantity[0], quantity.substr(1)};
  } else if (is_axis(quantity.back()) && quantity[quantity.size() - 2] == '_') {
    axis = quantity.back();
    name = quantity.substr(0, quantity.size() - 2);
  } else if (is_axis(quantity.front()) && quantity[1] == '_') {
    axis = quantity.front();
    name = quantity.substr(2);
  }
  if (is_one_of(name, {"position", "pos", "coord", "coordinate", "centroid", "center", "centre", "axis"}))
    name.clear();
  return {axis, name};
}

/// "t", "time", "t_{1}", "position_t"
bool is_time(const std::string& quantity) {
  const std::string_view word =
      std::string_view(quantity).substr(0, quantity.find_last_not_of("0123456789_") + 1);
  return is_one_of(word, {"t", "time", "elapsed_time", "timestamp", "time_stamp", "zeit", "temps", "tiempo",
                          "tempo", "position_t"});
}

bool is_frame(const std::string& quantity) {
  return is_one_of(quantity, {"frame", "frames", "frame_number", "frame_no", "frame_nr", "image", "slice",
                              "slice_ndeg", "bild", "bildnummer"});
}

bool is_particle(const std::string& quantity) {
  return is_one_of(quantity, {"particle", "track_id", "trajectory", "track_ndeg", "tid"});
}

/// Points as they come: x and y of one name find each other.
class Points {
 public:
  /// `column` holds an axis of the point; another of the same is the next point of that name.
  void add(char axis, bool sd, const std::string& name, const std::string& unit, std::size_t column) {
    for (Half& half : halves_) {
      std::size_t& place = half.at(axis, sd);
      if (half.name != name || half.unit != unit || place != kNowhere) continue;
      place = column;
      return;
    }
    halves_.push_back({name, unit});
    halves_.back().at(axis, sd) = column;
  }

  std::vector<PointColumns> whole() const {
    std::vector<PointColumns> points;
    for (const Half& half : halves_) {
      if (half.x == kNowhere || half.y == kNowhere) continue;
      PointColumns point{half.name, half.x, half.y, {}, {}, half.unit};
      if (half.x_sd != kNowhere && half.y_sd != kNowhere) {
        point.x_sd = half.x_sd;
        point.y_sd = half.y_sd;
      }
      // One point in two units: a length needs no scale, but the mark must be in it too.
      const auto same = std::ranges::find(points, half.name, &PointColumns::name);
      if (same != points.end() && same->unit != point.unit && !point.unit.empty() && !same->unit.empty()) {
        if ((same->unit == "px") != mark_in_pixels_alone()) *same = point;
        continue;
      }
      points.push_back(point);
    }
    return points;
  }

 private:
  struct Half {
    std::string name, unit;
    std::size_t x = kNowhere, y = kNowhere, x_sd = kNowhere, y_sd = kNowhere;
    std::size_t& at(char axis, bool sd) { return axis == 'x' ? (sd ? x_sd : x) : (sd ? y_sd : y); }
  };

  bool mark_in_pixels_alone() const {
    bool pixels = false, length = false;
    for (const Half& half : halves_)
      if (half.name == "marker" || half.name == "mark") (half.unit == "px" ? pixels : length) = true;
    return pixels && !length;
  }

  std::vector<Half> halves_;
};

/// pt1_cam1_X; nothing where the cell is none.
bool take_dltdv(const std::string& cell, std::size_t column, Points& points) {
  static const std::regex form(R"(pt(\d+)(_cam(\d+))?_([XYZ]))", std::regex::icase);
  std::smatch match;
  if (cell.size() > 40 || !std::regex_match(cell, match, form)) return false;
  const std::string camera = match[3].matched && match[3].str() != "1" ? "_cam" + match[3].str() : "";
  const char axis = match[4].str()[0];
  if (axis != 'Z' && axis != 'z')
    points.add(axis == 'X' || axis == 'x' ? 'x' : 'y', false, "pt" + match[1].str() + camera, "px", column);
  return true;
}

/// The name that stands above a column, or above one to the left of it.
std::string name_above(const Cells& above, std::size_t column) {
  for (std::size_t k = std::min(column + 1, above.size()); k > 0; --k)
    if (!above[k - 1].empty() && !above[k - 1].starts_with('#')) return std::string(above[k - 1]);
  return "";
}

/// A subset's displacement and its sd, of both axes alike.
bool take_dice(const Cells& cells, TrackColumns& columns) {
  const auto point = std::ranges::find(columns.points, "displacement", &PointColumns::name);
  const auto sigma = std::ranges::find(cells, "SIGMA");
  if (!columns.frame || point == columns.points.end() || sigma == cells.end()) return false;
  PointColumns subset = *point;
  subset.name.clear();
  subset.unit = "px";
  subset.x_sd = subset.y_sd = static_cast<std::size_t>(sigma - cells.begin());
  columns.points = {subset};
  columns.layout = "DICe";
  columns.y = "down";
  columns.no_sd_is_lost = true;
  return true;
}

/// Cells that name a column of a track; 0 without an x and a y.
int known_in(const Cells& cells) {
  int known = 0, x = 0, y = 0;
  for (const std::string_view cell : cells) {
    Points points;
    const bool dltdv = take_dltdv(std::string(cell), 0, points);
    const std::string quantity = heading_of(cell).quantity;
    const char axis = axis_of(quantity).first;
    x += dltdv || axis == 'x';
    y += dltdv || axis == 'y';
    known += dltdv || axis != 0 || is_time(quantity) || is_frame(quantity) || is_particle(quantity);
  }
  return x > 0 && y > 0 ? known : 0;
}

}  // namespace

CsvTable track_table(const fs::path& path, std::string text) {
  return {path, std::move(text), known_in};
}

TrackColumns read_track_columns(const CsvTable& table) {
  TrackColumns columns;
  Points points;
  bool dltdv = false, milliseconds = false, image_j = false;
  const auto point = [&](std::size_t column, const std::string& name) {
    return name.empty() ? name_above(table.above_header(), column) : name;
  };
  for (std::size_t k = 0; k < table.header().size(); ++k) {
    if (take_dltdv(std::string(table.header()[k]), k, points)) {
      dltdv = true;
      continue;
    }
    const Heading heading = table.heading(k);
    const auto [axis, name] = axis_of(heading.quantity);
    const bool place = heading.unit.empty() || si_per(heading.unit, Dimension::length) ||
                       si_per(heading.unit, Dimension::pixels);
    if (axis != 0 && place) {
      points.add(axis, heading.sd, point(k, name), heading.unit, k);
    } else if (!columns.time && is_time(heading.quantity) &&
               (heading.unit.empty() || si_per(heading.unit, Dimension::time))) {
      columns.time = k;
      columns.second = heading.unit.empty() ? 1 : *si_per(heading.unit, Dimension::time);
      milliseconds = heading.unit == "ms";
    } else if (!columns.frame && is_frame(heading.quantity)) {
      columns.frame = k;
      image_j = heading.quantity.starts_with("slice");
    } else if (!columns.particle && is_particle(heading.quantity)) {
      columns.particle = k;
    }
  }
  columns.points = points.whole();
  if (columns.points.empty())
    throw InvalidInput("{}: is not a track: no line above its numbers names an x and a y: {}; {}",
                       table.path().string(), table.holds(), kTrackLayouts);
  const bool named_above =
      std::ranges::any_of(table.above_header(), [](std::string_view cell) { return !cell.empty(); });
  if (take_dice(table.header(), columns)) return columns;
  if (dltdv) {
    columns.layout = "DLTdv";
  } else if (image_j || (columns.particle && columns.frame)) {
    columns.layout = image_j ? "ImageJ" : columns.time ? "TrackMate" : "trackpy";
    columns.y = "down";
    columns.usual_unit = "px";
  } else if (columns.time && (milliseconds || table.is_remarked("Kinovea"))) {
    columns.layout = "Kinovea";
    columns.y = "up";
    // Its text export: a trajectory after the other, each under its name, times in ms or as h:mm:ss:cc.
    columns.by_section = !milliseconds;
    if (columns.by_section) columns.second = 1e-3;
  } else if (columns.time && named_above) {
    columns.layout = "Tracker";
    columns.y = "up";
  } else {
    columns.layout = "t, x, y";
  }
  return columns;
}

}  // namespace tribotrack::apps
