// Times of a rolling shutter's rows.
#include <vector>

#include "vision/track.h"

namespace tribotrack::vision {
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
