#include <fmt/core.h>

#include <array>
#include <cmath>

#include "vision/picture.h"
#include "vision/time_base.h"
#include "vision/track.h"

namespace tribotrack::vision {
namespace {

std::string in_hz(double rate) {
  return fmt::format("{:.6g} Hz", rate);
}

}  // namespace

std::string TimeBase::why_unknown() const {
  if (known()) return "";
  std::string text = "the capture rate is unknown";
  if (candidates.empty())
    text += ", nothing in the recording states it";
  else
    text += ", nothing in the recording establishes it";
  const char* separator = ": ";
  for (const TimeBaseCandidate& candidate : candidates) {
    text += separator + candidate.source;
    if (candidate.rate_hz > 0) text += " state " + in_hz(candidate.rate_hz);
    text += " (" + candidate.reason + ")";
    separator = "; ";
  }
  return text + "; give the rate the camera recorded at with --fps HZ (campaign: frame_rate_hz)";
}

std::optional<double> usual_playback_rate(double rate_hz, double tolerance) {
  constexpr std::array<double, 10> usual = {24, 25, 29.97, 30, 50, 59.94, 60, 600, 1000, 65535};
  std::optional<double> nearest;
  for (double rate : usual) {
    if (std::abs(rate_hz / rate - 1) > tolerance) continue;
    if (!nearest || std::abs(rate_hz - rate) < std::abs(rate_hz - *nearest)) nearest = rate;
  }
  return nearest;
}

TimeBaseCandidate user_rate(double rate_hz, const std::string& reason) {
  if (!(rate_hz > 0) || !std::isfinite(rate_hz))
    throw InputError("the frame rate given (--fps, frame_rate_hz) is " + std::to_string(rate_hz) +
                     " but must be a positive number of frames per second");
  return {"--fps", rate_hz, true, "given by the user" + (reason.empty() ? "" : ": " + reason)};
}

void require_reason(double user_rate_hz, const std::string& reason, const TimeBaseCandidate& stated) {
  constexpr double kFastestPlayback = 60.1;  // faster ones are the cameras' own, or a container's ticks
  if (!reason.empty() || stated.accepted || stated.rate_hz > kFastestPlayback) return;
  const auto playback = usual_playback_rate(stated.rate_hz);
  if (!playback || usual_playback_rate(user_rate_hz) != playback) return;
  throw InputError(fmt::format(
      "the frame rate given (--fps, frame_rate_hz), {}, is the playback rate that {} state: players set it "
      "whatever the camera did. Give the rate of recording or, if this is it, how you know: --fps-reason "
      "TEXT "
      "(campaign: frame_rate_reason = \"TEXT\")",
      in_hz(user_rate_hz), stated.source));
}

TimeBase choose_time_base(std::vector<TimeBaseCandidate> candidates) {
  TimeBase base;
  for (TimeBaseCandidate& candidate : candidates) {
    if (!candidate.accepted) continue;
    if (base.known()) {
      candidate.accepted = false;
      candidate.reason = base.source + " is trusted more";
    } else {
      base.rate_hz = candidate.rate_hz;
      base.source = candidate.source;
    }
  }
  base.candidates = std::move(candidates);
  return base;
}

// Times of a rolling shutter's rows.

namespace {

/// Of the mark, px/s, from the neighbouring points that show it; nothing where none does.
Point velocity_of_mark(const std::vector<TrackPoint>& points, std::size_t k) {
  const std::size_t before = k > 0 && points[k - 1].marker ? k - 1 : k;
  const std::size_t after = k + 1 < points.size() && points[k + 1].marker ? k + 1 : k;
  const double time = points[after].time_s - points[before].time_s;
  if (!(time > 0)) return {};
  const MarkerPoint &a = *points[before].marker, &b = *points[after].marker;
  return {(b.x - a.x) / time, (b.y - a.y) / time};
}

}  // namespace

void shift_to_rows(Track& track, double row_time, double middle_row) {
  const std::vector<TrackPoint> as_read = track.points;
  for (std::size_t k = 0; k < as_read.size(); ++k) {
    TrackPoint& p = track.points[k];
    if (p.status != TrackStatus::ok) continue;
    p.time_s += row_time * (p.y - middle_row);
    if (!p.marker) continue;
    const Point v = velocity_of_mark(as_read, k);
    const double later = row_time * (p.y - p.marker->y);
    p.marker->x += v.x * later;
    p.marker->y += v.y * later;
  }
}

}  // namespace tribotrack::vision
