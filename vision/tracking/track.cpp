#include "vision/track.h"

#include <algorithm>
#include <cmath>

namespace tribotrack::vision {

const char* to_string(TrackStatus status) {
  switch (status) {
    case TrackStatus::ok:
      return "ok";
    case TrackStatus::edge:
      return "edge";
    case TrackStatus::lost:
      break;
  }
  return "lost";
}

std::optional<double> Audit::halves() const {
  if (!halves_x || !halves_y) return std::nullopt;
  return std::hypot(*halves_x, *halves_y) / std::sqrt(2.0);
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
