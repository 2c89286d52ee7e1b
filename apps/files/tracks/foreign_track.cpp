#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "apps/files/tracks/any_track.h"
#include "apps/program/errors.h"
#include "apps/text/csv_table.h"
#include "fit/measurement.h"

namespace tribotrack::apps {

namespace {

constexpr double kUniform = 0.2887;  ///< sd of what is rounded to 1: 1/sqrt(12)

/// Where the times of the frames come from.
struct Clock {
  std::optional<double> rate_hz;
  std::string from, warning;
};

/// The upper of two middle ones.
double median_of(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Frame numbers as the times count them, from 0.
std::vector<std::int64_t> numbered_by(const std::vector<double>& time, double step) {
  std::vector<std::int64_t> numbers;
  for (const double t : time) numbers.push_back(std::llround((t - time.front()) / step));
  return numbers;
}

/// Interval between neighbours that are one frame apart, refined by the whole length.
double interval_of(const std::filesystem::path& path, const std::vector<double>& time) {
  constexpr double kMostFrames = 1e9;
  std::vector<double> steps;
  for (std::size_t k = 1; k < time.size(); ++k) steps.push_back(time[k] - time[k - 1]);
  double step = median_of(steps);
  if (!(time.back() - time.front() < kMostFrames * step))
    throw InvalidInput("{}: its times are no times of frames: most are {:.3g} s apart, all of them {:.3g} s",
                       path.string(), step, time.back() - time.front());
  // Rounded times have few values of step: count frames with an ever better one.
  constexpr double kFirst = 8, kFurther = 1.5;
  const double whole = time.back() - time.front();
  for (double reach = kFirst * step; reach < kFurther * whole; reach *= kFurther) {
    const auto beyond = std::upper_bound(time.begin(), time.end(), time.front() + reach);
    const double span = *(beyond - 1) - time.front();
    if (const double frames = std::round(span / step); frames > 0) step = span / frames;
  }
  return step;
}

/// t = a + b n by least squares.
std::pair<double, double> line_through(const std::vector<std::int64_t>& n, const std::vector<double>& t) {
  double mean_n = 0, mean_t = 0, nn = 0, nt = 0;
  const auto count = static_cast<double>(n.size());
  for (std::size_t k = 0; k < n.size(); ++k) {
    mean_n += static_cast<double>(n[k]) / count;
    mean_t += t[k] / count;
  }
  for (std::size_t k = 0; k < n.size(); ++k) {
    nn += std::pow(static_cast<double>(n[k]) - mean_n, 2);
    nt += (static_cast<double>(n[k]) - mean_n) * (t[k] - mean_t);
  }
  const double b = nt / nn;
  return {mean_t - b * mean_n, b};
}

/// A rate at which films are played, not taken: Clock::warning.
std::string playback_warning(double rate) {
  for (const double played : {24000.0 / 1001, 24.0, 25.0, 30000.0 / 1001, 30.0, 50.0, 60000.0 / 1001, 60.0})
    if (std::abs(rate / played - 1) < 1e-4)
      return fmt::format(
          "its times follow each other at {:.4g} frames/s, at which films are played: if the camera was "
          "faster, give frame_rate_hz in [camera] (--fps)",
          rate);
  return "";
}

/// Numbers and times the part's samples as the frames were taken.
Clock set_clock(const std::filesystem::path& path, std::vector<PointSample>& samples,
                const TrackColumns& columns, const TrackReading& reading) {
  std::vector<double> time;
  for (const PointSample& at : samples) time.push_back(at.time);
  if (reading.frame_rate_hz) {
    if (columns.time && !columns.frame) {
      const std::vector<std::int64_t> numbers = numbered_by(time, interval_of(path, time));
      for (std::size_t k = 0; k < samples.size(); ++k) samples[k].frame = numbers[k];
    }
    for (PointSample& at : samples) at.time = static_cast<double>(at.frame) / *reading.frame_rate_hz;
    return {reading.frame_rate_hz, "frame numbers and the given rate", ""};
  }
  if (!columns.time)
    throw InvalidInput(
        "{}: has no times; give the rate at which its frames were taken, frame_rate_hz in [camera] (--fps)",
        path.string());
  const std::vector<std::int64_t> numbers = numbered_by(time, interval_of(path, time));
  const auto [start, interval] = line_through(numbers, time);
  double off = 0;
  for (std::size_t k = 0; k < numbers.size(); ++k)
    off = std::max(off, std::abs(time[k] - start - interval * static_cast<double>(numbers[k])));
  const bool even = off <= 0.6 * std::ranges::min(samples, {}, &PointSample::time_step).time_step;
  const bool distinct = std::adjacent_find(numbers.begin(), numbers.end()) == numbers.end();
  if (even && distinct)
    for (std::size_t k = 0; k < numbers.size(); ++k) {
      samples[k].time = start + interval * static_cast<double>(numbers[k]);
      if (!columns.frame) samples[k].frame = numbers[k];
    }
  return {1 / interval, even && distinct ? "times in the file, on an even grid" : "times in the file",
          playback_warning(1 / interval)};
}

/// The unit of a point, and millimetres to one; of pixels the given scale.
struct Scale {
  std::string unit;
  bool pixels = false;
  double mm = 0;
};

Scale scale_of(const CsvTable& table, const TrackColumns& columns, const TrackReading& reading) {
  const std::string& unit = columns.points.front().unit;
  Scale scale{!unit.empty() ? unit : !reading.unit.empty() ? reading.unit : columns.usual_unit};
  if (scale.unit.empty())
    table.fail(
        "does not say in which unit x and y are: write it into the header (x_mm, y_mm), or give track_unit = "
        "\"mm\" in the run or in [data] (--track-unit)");
  if (const auto si = si_per(scale.unit, Dimension::length)) {
    scale.mm = *si * 1e3;
    return scale;
  }
  if (!reading.mm_per_px)
    throw InvalidInput("{}: is in pixels; give mm_per_px in the run or in [camera] (--mm-per-px)",
                       table.path().string());
  scale.pixels = true;
  scale.mm = *reading.mm_per_px;
  return scale;
}

bool y_points_up(const CsvTable& table, const TrackColumns& columns, const Scale& scale,
                 const TrackReading& reading) {
  if (!reading.y.empty()) return reading.y == "up";
  if (columns.layout == "DLTdv")
    table.fail(
        "is a table of DLTdv, whose y points up until version 5 and in Argus, down from version 8 on: say "
        "which, track_y = \"up\" or \"down\" in the run or in [data] (--track-y)");
  return columns.y.empty() ? !scale.pixels : columns.y == "up";
}

/// Gives samples without sds those of their scatter, at the frames of the part: fit::PointNoise::dof.
double estimate_sds(const CsvTable& table, const PointSamples& part, PointSamples& samples) {
  std::vector<std::int64_t> seen;
  std::vector<Eigen::Vector2d> positions;
  double step = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < samples.at.size(); ++k)
    if (const PointSample& at = samples.at[k]; at.seen()) {
      seen.push_back(part.at[k].frame);
      positions.emplace_back(at.x, at.y);
      step = std::min(step, at.step);
    }
  const auto estimate = fit::point_noise(seen, positions);
  const std::string of_mark = &samples == &part ? "" : samples.name + "_";
  if (!estimate)
    throw InvalidInput(
        "{}: has no standard deviations, and with {} points that follow each other too few to estimate them; "
        "add the columns {}x_sd_mm and {}y_sd_mm",
        table.path().string(), positions.size(), of_mark, of_mark);
  // Rounding is the least error there is.
  const Eigen::Vector2d sd = estimate->sd.cwiseMax(kUniform * step);
  for (PointSample& at : samples.at) {
    at.x_sd = sd.x();
    at.y_sd = sd.y();
  }
  return estimate->dof;
}

/// As `track` follows a part, y down, in the file's own unit: one pixel is one of it.
vision::Track followed(const PartAndMark& points, bool up, const TrackReading& reading) {
  vision::Track track;
  track.has_marker = points.mark.has_value();
  const double down = up ? -1 : 1;
  for (std::size_t k = 0; k < points.part.at.size(); ++k) {
    const PointSample& part = points.part.at[k];
    if (reading.first_frame && part.frame < *reading.first_frame) continue;
    if (reading.last_frame && part.frame > *reading.last_frame) continue;
    vision::TrackPoint& point = track.points.emplace_back();
    point.frame = part.frame;
    point.time_s = part.time;
    point.ncc = TrackRow::kNone;
    if (part.seen()) {
      point.status = vision::TrackStatus::ok;
      point.x = part.x;
      point.y = down * part.y;
      point.sigma_x = part.x_sd;
      point.sigma_y = part.y_sd;
    }
    if (points.mark && points.mark->at[k].seen()) {
      const PointSample& mark = points.mark->at[k];
      const double sd = Eigen::Vector2d(mark.x_sd, mark.y_sd).norm() / std::sqrt(2.0);  // one for both axes
      point.marker = vision::MarkerPoint{mark.x, down * mark.y, sd, TrackRow::kNone};
    }
  }
  return track;
}

std::string sd_text(const PointSamples& part, const std::string& unit) {
  if (part.has_sd) return "sds as the file has them";
  return fmt::format(
      "sds of {:.2g} {} in x and {:.2g} {} in y from the scatter from point to point, which does not show "
      "errors slower than the frames",
      part.at.front().x_sd, unit, part.at.front().y_sd, unit);
}

}  // namespace

ForeignTrack read_foreign_track(const std::filesystem::path& path, std::string text,
                                const TrackReading& reading) {
  Input input = hashed_input(path, text);
  CsvTable table = track_table(path, std::move(text));
  const TrackColumns columns = read_track_columns(table);
  // What the header leaves open is said at its line.
  const std::string& header_unit = columns.points.front().unit;
  const Scale scale = scale_of(table, columns, reading);
  const bool up = y_points_up(table, columns, scale, reading);
  PartAndMark points = read_points(table, columns, reading);
  if (!reading.frame.empty() && !reading.mark.empty())
    throw InvalidInput(
        "{}: track_mark takes the platform's motion out of the positions, and track_frame = \"{}\" says that "
        "they stay as they are; give one of them",
        path.string(), reading.frame);
  if (!reading.frame.empty()) points.mark.reset();
  if (points.mark && points.mark->unit != points.part.unit)
    throw InvalidInput("{}: part and mark are in different units, {} and {}", path.string(), points.part.unit,
                       points.mark->unit);
  if (points.part.unit != header_unit)
    throw InvalidInput("{}: its points are in different units", path.string());
  if (points.part.at.size() < 2)
    throw InvalidInput("{}: holds fewer than two rows of numbers", path.string());
  const Clock clock = set_clock(path, points.part.at, columns, reading);
  const double dof = points.part.has_sd ? 0 : estimate_sds(table, points.part, points.part);
  if (points.mark && !points.mark->has_sd) estimate_sds(table, points.part, *points.mark);

  ForeignTrack track;
  const vision::PlaneGeometry geometry(vision::given_scale(scale.mm), vision::ScalePlane::platform, {});
  track.rows = track_rows(followed(points, up, reading), geometry, reading.xi_axis_rad, scale.pixels);
  if (track.rows.rows.empty()) throw InvalidInput("{}: no row lies within `frames`", path.string());
  const bool of_platform = points.mark || reading.frame == "platform";
  const std::string read_as =
      fmt::format("read as {} (x, y in {}, y {}{}{}); {}",
                  columns.layout == "t, x, y" ? "t, x, y" : "a track of " + columns.layout, scale.unit,
                  up ? "up" : "down", points.part.name.empty() ? "" : "; part " + points.part.name,
                  points.mark   ? "; mark " + points.mark->name
                  : of_platform ? "; relative to the platform"
                                : "; no mark: the positions hold the platform's motion",
                  sd_text(points.part, scale.unit));
  std::vector<std::string> warnings = {read_as};
  if (!clock.warning.empty()) warnings.push_back(clock.warning);
  const auto lost = std::ranges::count(track.rows.rows, vision::TrackStatus::lost, &TrackRow::status);
  track.meta.command = "track";
  track.meta.inputs = {std::move(input)};
  track.meta.configuration = {{"xi_axis_rad", reading.xi_axis_rad},
                              {"frame_rate_hz", optional_json(reading.frame_rate_hz)},
                              {"mm_per_px", optional_json(reading.mm_per_px)},
                              {"unit", reading.unit},
                              {"frame", reading.frame},
                              {"point", reading.point},
                              {"mark", reading.mark}};
  Json& more = track.meta.more;
  more["imported"] = {{"layout", columns.layout}, {"reading", read_as}};
  more["time_base"] = {{"rate_hz", optional_json(clock.rate_hz)}, {"source", clock.from}};
  more["frame_of_reference"] = of_platform ? "platform" : "camera";
  if (points.mark) more["platform_seen_by"] = "marker";
  more["scale"] =
      scale.pixels
          ? Json{{"mm_per_px", scale.mm}, {"mm_per_px_sd", reading.mm_per_px_sd}, {"source", "given"}}
          : Json();
  more["summary"] = {{"frames", track.rows.rows.size()},
                     {"ok", static_cast<std::int64_t>(track.rows.rows.size()) - lost},
                     {"lost", lost},
                     {"gate_passed", true},
                     {"sd_from_scatter", !points.part.has_sd},
                     {"sd_dof", dof},
                     {"warnings", warnings}};
  return track;
}

}  // namespace tribotrack::apps
