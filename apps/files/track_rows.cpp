#include "apps/files/track_rows.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <ranges>
#include <utility>

#include "apps/program/errors.h"

namespace tribotrack::apps {

namespace {

/// px, mm, rad: no camera sees that far, and squares of what is below can be added up.
constexpr double kBeyondAllPictures = 1e9;

enum class Group { always, rotation, marker, gate, planes };

struct RowColumn {
  const char* name;
  double TrackRow::*number;  ///< null: the status
  Group group = Group::always;
};

/// After `frame` and `time_s`, in the file's order.
constexpr std::array<RowColumn, 22> kColumns = {
    {{"x_px", &TrackRow::x_px},
     {"y_px", &TrackRow::y_px},
     {"sigma_x_px", &TrackRow::sigma_x_px},
     {"sigma_y_px", &TrackRow::sigma_y_px},
     {"rho_xy", &TrackRow::rho_xy},
     {"ncc", &TrackRow::ncc},
     {"status", nullptr},
     {"x_mm", &TrackRow::x_mm},
     {"y_mm", &TrackRow::y_mm},
     {"sigma_x_mm", &TrackRow::sigma_x_mm},
     {"sigma_y_mm", &TrackRow::sigma_y_mm},
     {"theta_rad", &TrackRow::theta_rad, Group::rotation},
     {"sigma_theta_rad", &TrackRow::sigma_theta_rad, Group::rotation},
     {"marker_x_px", &TrackRow::marker_x_px, Group::marker},
     {"marker_y_px", &TrackRow::marker_y_px, Group::marker},
     {"marker_sigma_px", &TrackRow::marker_sigma_px, Group::marker},
     {"marker_ncc", &TrackRow::marker_ncc, Group::marker},
     {"gate", &TrackRow::gate, Group::gate},
     {"rho_xy_mm", &TrackRow::rho_xy_mm, Group::planes},
     {"marker_x_mm", &TrackRow::marker_x_mm, Group::planes},
     {"marker_y_mm", &TrackRow::marker_y_mm, Group::planes},
     {"marker_sigma_mm", &TrackRow::marker_sigma_mm, Group::planes}}};

bool holds(const TrackRows& rows, Group group) {
  return group == Group::always || (group == Group::rotation && rows.has_rotation) ||
         (group == Group::marker && rows.has_marker) || (group == Group::gate && rows.has_gate) ||
         (group == Group::planes && rows.has_planes);
}

void put_millimetres(TrackRow& row, const vision::PlacedPoint& point, bool planes) {
  const Eigen::Matrix2d& c = point.covariance;
  row.x_mm = as_written(point.mm.x());
  row.y_mm = as_written(point.mm.y());
  row.sigma_x_mm = as_written(std::sqrt(c(0, 0)));
  row.sigma_y_mm = as_written(std::sqrt(c(1, 1)));
  if (!planes) return;
  row.rho_xy_mm = as_written(c(0, 1) / std::sqrt(c(0, 0) * c(1, 1)));
  if (!point.marker_mm) return;
  row.marker_x_mm = as_written(point.marker_mm->x());
  row.marker_y_mm = as_written(point.marker_mm->y());
  row.marker_sigma_mm = as_written(point.marker_sigma_mm);
}

int known_in(const Cells& cells) {
  return static_cast<int>(std::ranges::count_if(cells, [](std::string_view cell) {
    return cell == "frame" || cell == "time_s" || std::ranges::count(kColumns, cell, &RowColumn::name) > 0;
  }));
}

/// Where each column stands in a file; a column that is not there stands behind the last.
class Places {
 public:
  explicit Places(const CsvTable& table) : header_(table.header()) {
    const Columns all = columns_of(TrackRows());
    for (const char* needed : {"frame", "time_s", "status", "x_mm", "y_mm", "sigma_x_mm", "sigma_y_mm"})
      if (!has(needed))
        table.fail(fmt::format("has no column `{}`: {}; a track has {}", needed, table.holds(),
                               fmt::join(all | std::views::keys, ",")));
    frame_ = place_of("frame");
    time_ = place_of("time_s");
    for (std::size_t k = 0; k < kColumns.size(); ++k) places_[k] = place_of(kColumns[k].name);
  }

  bool has(std::string_view name) const { return place_of(name) < header_.size(); }

  TrackRow read(const CsvTable& table) const {
    const auto& cells = table.cells();
    if (cells.size() != header_.size())
      table.fail(fmt::format("has {} columns where {} belong", cells.size(), header_.size()));
    TrackRow row;
    row.frame = frame_of(table, cells[frame_]);
    row.time_s = table.number(cells[time_]);
    for (std::size_t k = 0; k < kColumns.size(); ++k) {
      if (places_[k] == header_.size()) continue;
      const std::string_view cell = cells[places_[k]];
      if (kColumns[k].number == nullptr)
        row.status = status_of(table, cell);
      else if (!cell.empty())
        row.*kColumns[k].number = number_of(table, cell, kColumns[k]);
    }
    return row;
  }

 private:
  std::size_t place_of(std::string_view name) const {
    return static_cast<std::size_t>(std::ranges::find(header_, name) - header_.begin());
  }
  static std::int64_t frame_of(const CsvTable& table, std::string_view cell) {
    constexpr double exact = 0x1p53;  // beyond it a double skips whole numbers
    const double frame = table.number(cell);
    if (!(std::abs(frame) <= exact) || frame != std::floor(frame))
      table.fail(cell, fmt::format("`{}` is no frame's number; it must be a whole number", cell));
    return static_cast<std::int64_t>(frame);
  }
  static vision::TrackStatus status_of(const CsvTable& table, std::string_view cell) {
    using vision::TrackStatus;
    for (const TrackStatus status :
         {TrackStatus::ok, TrackStatus::lost, TrackStatus::edge, TrackStatus::repeat})
      if (cell == vision::to_string(status)) return status;
    table.fail(cell, fmt::format("`{}` is no status; it must be ok, lost, edge or repeat", cell));
  }
  static double number_of(const CsvTable& table, std::string_view cell, const RowColumn& column) {
    double value = 0;
    try {
      value = table.number(cell);
    } catch (const InvalidInput& error) {
      throw InvalidInput("{} in column {}", error.what(), column.name);
    }
    if (std::abs(value) > kBeyondAllPictures)
      table.fail(cell, fmt::format("{} in column {} is out of range; at most {:g} can be", cell, column.name,
                                   kBeyondAllPictures));
    const std::string_view name = column.name;
    if (!(value > 0) && (name.starts_with("sigma_") || name.starts_with("marker_sigma_")))
      table.fail(cell, fmt::format("{} in column {} must be greater than 0: it is a standard deviation", cell,
                                   name));
    return value;
  }

  const Cells& header_;
  std::size_t frame_ = 0, time_ = 0;
  std::array<std::size_t, kColumns.size()> places_{};
};

}  // namespace

TrackRows track_rows(const vision::Track& track, const std::optional<vision::PlaneGeometry>& geometry,
                     double xi_axis_rad, bool pixels) {
  std::vector<std::optional<vision::PlacedPoint>> millimetres(track.points.size());
  if (geometry) millimetres = vision::place_track(track, *geometry, xi_axis_rad);
  TrackRows table;
  table.has_rotation = track.has_rotation;
  table.has_marker = track.has_marker;
  table.has_gate = track.has_gate;
  table.has_planes = geometry && (!geometry->plain() || !pixels);
  for (std::size_t k = 0; k < track.points.size(); ++k) {
    const vision::TrackPoint& p = track.points[k];
    TrackRow row;
    row.frame = p.frame;
    row.time_s = p.time_s;
    row.status = p.status;
    if (p.status == vision::TrackStatus::ok && pixels) {
      row.x_px = as_written(p.x);
      row.y_px = as_written(p.y);
      row.sigma_x_px = as_written(p.sigma_x);
      row.sigma_y_px = as_written(p.sigma_y);
      row.rho_xy = as_written(p.rho_xy);
      row.ncc = as_written(p.ncc);
    }
    if (millimetres[k]) put_millimetres(row, *millimetres[k], table.has_planes);
    if (p.rotation) {
      row.theta_rad = as_written(p.rotation->theta);
      row.sigma_theta_rad = as_written(p.rotation->sigma);
    }
    if (p.marker && pixels) {
      row.marker_x_px = as_written(p.marker->x);
      row.marker_y_px = as_written(p.marker->y);
      row.marker_sigma_px = as_written(p.marker->sigma);
      row.marker_ncc = as_written(p.marker->ncc);
    }
    if (p.gate) row.gate = as_written(*p.gate);
    table.rows.push_back(row);
  }
  return table;
}

Columns columns_of(const TrackRows& table) {
  const auto values = [&](const auto& of) {
    std::vector<decltype(of(TrackRow()))> all;
    for (const TrackRow& row : table.rows) all.push_back(of(row));
    return all;
  };
  Columns columns = {{"frame", values([](const TrackRow& row) { return row.frame; })},
                     {"time_s", values([](const TrackRow& row) { return row.time_s; })}};
  for (const auto& [name, number, group] : kColumns) {
    if (!holds(table, group)) continue;
    if (number == nullptr)
      columns.emplace_back(name, values([](const TrackRow& row) { return vision::to_string(row.status); }));
    else
      columns.emplace_back(name, values([of = number](const TrackRow& row) { return row.*of; }));
  }
  return columns;
}

std::string track_csv(const TrackRows& table) {
  return csv_of(columns_of(table));
}

TrackRows read_track_rows(const std::filesystem::path& path, std::string text) {
  CsvTable csv(path, std::move(text), known_in);
  if (csv.holds() == "it is empty")
    throw InvalidInput("{}: is not a track: it is empty; make one with `tribotrack track`", path.string());
  const Places places(csv);
  TrackRows table;
  table.has_rotation = places.has("theta_rad");
  if (table.has_rotation != places.has("sigma_theta_rad"))
    csv.fail(
        fmt::format("has only one of the columns `theta_rad` and `sigma_theta_rad`; they belong together"));
  table.has_marker = places.has("marker_x_px");
  table.has_gate = places.has("gate");
  table.has_planes = places.has("rho_xy_mm");
  while (csv.next()) {
    table.rows.push_back(places.read(csv));
    const auto count = table.rows.size();
    if (count > 1 && !(table.rows[count - 1].time_s > table.rows[count - 2].time_s))
      csv.fail(
          "its time_s does not increase; put the rows in the order of time, or track the recording again");
  }
  if (table.rows.empty())
    throw InvalidInput("{}: is a track that has no rows below its header; track the recording again",
                       path.string());
  return table;
}

}  // namespace tribotrack::apps
