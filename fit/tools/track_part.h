// Some of a track's points.
#pragma once

#include <cstddef>

#include "fit/track_table.h"

namespace tribotrack::fit::internal {

/// The points [first, last).
inline TrackTable part_of(const TrackTable& track, std::size_t first, std::size_t last) {
  TrackTable part = track;
  const auto keep = [&](auto& column) {
    if (column.size() < last) return;
    column.erase(column.begin() + static_cast<std::ptrdiff_t>(last), column.end());
    column.erase(column.begin(), column.begin() + static_cast<std::ptrdiff_t>(first));
  };
  keep(part.frame);
  keep(part.time);
  keep(part.position);
  keep(part.covariance);
  keep(part.angle);
  keep(part.angle_sigma);
  keep(part.marker);
  keep(part.marker_sigma);
  return part;
}

}  // namespace tribotrack::fit::internal
