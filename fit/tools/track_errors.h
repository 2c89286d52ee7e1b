// The errors of a track's points, and how they hang together.
//
// The covariance of two points is  delta_ij own_i + a_i a_j sum_p s_p^2 exp(-|t_i - t_j|/T_p),  with s_p and
// T_p those of TrackTable::slow, and own_i what they leave of the point's covariance. a_i = 1, except where a
// point is known better than the slow errors say.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <utility>
#include <vector>

#include "fit/track_table.h"

namespace tribotrack::fit::internal {

/// One point's share of the two.
struct PointErrors {
  Eigen::Matrix2d own;  ///< m^2, of no other point
  double slow = 1;      ///< a
};

/// Of all slow errors, m^2 per axis: the covariance of two times so many seconds apart.
double slow_variance(const TrackTable& track, double apart);

/// Of one point, m^2 per axis.
double mean_variance(const TrackTable& track);

PointErrors point_errors(const TrackTable& track, std::size_t point);

/// Points and their weights in a sum.
using WeightedPoints = std::vector<std::pair<std::size_t, double>>;

/// Covariance of the sum of positions, m^2. A point may stand in it more than once.
Eigen::Matrix2d covariance_of_sum(const TrackTable& track, const WeightedPoints& sum);

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
