#include "vision/tracking/setup.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "vision/kernels/plane.h"
#include "vision/track.h"

namespace tribotrack::vision {
namespace {

constexpr double kStill = 0.5;  ///< px: noise and the search move a part at rest by less

}  // namespace

FrameCounts count(const Track& track, double max_lost_share) {
  FrameCounts counts;
  const auto& points = track.points;
  counts.frames = static_cast<std::int64_t>(points.size());
  for (const TrackPoint& p : points) {
    counts.ok += p.status == TrackStatus::ok;
    counts.lost += p.status == TrackStatus::lost;
    counts.edge += p.status == TrackStatus::edge;
  }
  // Left for good: not seen again after an edge.
  std::size_t end = points.size();
  while (end > 0 && points[end - 1].status != TrackStatus::ok) --end;
  counts.left_for_good = end < points.size() && points[end].status == TrackStatus::edge;
  const std::size_t counted = counts.left_for_good ? end : points.size();
  for (std::size_t k = 0; k < counted; ++k) counts.lost_counted += points[k].status == TrackStatus::lost;
  counts.gate_passed = static_cast<double>(counts.lost_counted) <=
                       max_lost_share * static_cast<double>(std::max<std::int64_t>(1, counts.frames));
  return counts;
}

PlanStage ground_marker_stage(const std::string& ground, int learnt_from) {
  if (learnt_from == 0)
    return {.name = "marker",
            .reason = "none given, and " + ground + ": positions are in the camera's frame"};
  return {.name = "marker",
          .on = true,
          .reason =
              fmt::format("none: {}; learnt from {} frames, its motion is subtracted", ground, learnt_from)};
}

std::string no_rim_warning(const char* what, const Circle& given) {
  return fmt::format(
      "the {}'s edge near ({:.1f}, {:.1f}) px is not seen as a circle: its given centre and radius are used "
      "as "
      "they are, and a scale from its diameter is as good as the given radius",
      what, given.x, given.y);
}

namespace {

/// Px across all places of the part, in the picture or against the marker; nothing for fewer than two.
std::optional<double> range_of(const Track& track, bool against_marker) {
  double left = 1e9, right = -1e9, top = 1e9, bottom = -1e9;
  std::int64_t seen = 0;
  for (const TrackPoint& p : track.points) {
    if (p.status != TrackStatus::ok || (against_marker && !p.marker)) continue;
    ++seen;
    const double x = against_marker ? p.x - p.marker->x : p.x, y = against_marker ? p.y - p.marker->y : p.y;
    left = std::min(left, x);
    right = std::max(right, x);
    top = std::min(top, y);
    bottom = std::max(bottom, y);
  }
  if (seen < 2) return std::nullopt;
  return std::hypot(right - left, bottom - top);
}

}  // namespace

std::optional<std::string> rest_warning(const Track& track, const Circle& disc, bool against_marker) {
  const auto range = range_of(track, against_marker);
  if (!range || *range > kStill) return std::nullopt;
  return fmt::format(
      "the disc that was found at ({:.1f}, {:.1f}) px {}", disc.x, disc.y,
      against_marker
          ? fmt::format("goes where the ground goes, within {:.2f} px: the part, held by the platform, or "
                        "something fixed to it? Give the part with --disc X,Y,R",
                        *range)
          : fmt::format("stays within {:.2f} px and is no moving part: give the part with --disc X,Y,R",
                        *range));
}

std::optional<std::string> without_a_mark(Track& track, std::size_t begin) {
  auto& points = track.points;
  const TrackPoint start = points[begin];
  std::size_t end = begin;
  for (; end < points.size() && points[end].status == TrackStatus::ok; ++end)
    if (distance(points[end], start) > kStill) return std::nullopt;
  for (std::size_t k = begin; k < end; ++k) points[k].status = TrackStatus::lost;
  return fmt::format(
      "the part had left the picture; what looks like it at ({:.1f}, {:.1f}) px in frames {} to {} does not "
      "move: it is taken for a mark on the ground",
      start.x, start.y, start.frame, points[end - 1].frame);
}

std::string TrackSummary::brief_report() const {
  std::string text = fmt::format("{} frames: {} ok, {} lost, {} edge", frames, ok, lost, edge);
  if (repeats > 0) text += fmt::format(", {} repeat", repeats);
  if (refound > 0) text += fmt::format(", found again {} times", refound);
  if (absent_at_first > 0) text += fmt::format(", not there in the first {}", absent_at_first);
  if (left_for_good) text += ", left the picture for good";
  text += fmt::format("; noise {:.2f} grey levels", noise_levels);
  if (std::isfinite(limit_px)) text += fmt::format(", limit {:.4f} px", limit_px);
  if (disc.radius > 0)
    text += fmt::format("; disc at ({:.2f}, {:.2f}), radius {:.3f} px", disc.x, disc.y, disc.radius);
  if (rests_for_ever)
    text += "; NOT ACCEPTED: what was found by itself never moves";
  else if (!gate_passed)
    text +=
        "; NOT ACCEPTED: lost in more than the allowed share of frames (if something covers the part at "
        "first, begin "
        "later: --frames)";
  return text;
}

const char* to_string(TrackStatus status) {
  return std::array{"ok", "lost", "edge", "repeat"}.at(static_cast<std::size_t>(status));
}

double TrackSummary::slow_sd() const {
  double variance = 0;
  for (const SlowPart& part : slow) variance += part.sd * part.sd;
  return std::sqrt(variance);
}

double TrackSummary::slow_time() const {
  double variance = 0, sum = 0;
  for (const SlowPart& part : slow) {
    variance += part.sd * part.sd;
    sum += part.sd * part.sd * part.time;
  }
  return variance > 0 ? sum / variance : 0;
}

std::int64_t Track::first_seen() const {
  const auto seen = std::find_if(points.begin(), points.end(),
                                 [](const TrackPoint& p) { return p.status == TrackStatus::ok; });
  return seen != points.end() ? seen->frame : points.front().frame;
}

}  // namespace tribotrack::vision
