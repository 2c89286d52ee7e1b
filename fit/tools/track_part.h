// Some of a track's points.
#pragma once

#include <cstddef>
#include <utility>

#include "fit/track_table.h"

namespace tribotrack::fit::internal {

/// Every `every`-th of the points [first, last).
inline TrackTable part_of(const TrackTable& track, std::size_t first, std::size_t last,
                          std::size_t every = 1) {
  TrackTable part = track;
  const auto keep = [&](auto& column) {
    if (column.size() < last) return;
    const auto all = std::exchange(column, {});
    for (std::size_t i = first; i < last; i += every) column.push_back(all[i]);
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
