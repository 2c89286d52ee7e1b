// The covariance of a track's points by its definition in fit/tools/track_errors.h: dense and slow.
#pragma once

#include <Eigen/Core>
#include <cmath>

#include "fit/tools/track_errors.h"

namespace tribotrack::test {

/// m^2, rows (x, y) of one point below the other; `added` to each coordinate's own variance.
inline Eigen::MatrixXd dense_covariance(const fit::TrackTable& track, double added) {
  const auto n = static_cast<Eigen::Index>(track.time.size());
  Eigen::MatrixXd v(2 * n, 2 * n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j) {
      const auto a = static_cast<std::size_t>(i), b = static_cast<std::size_t>(j);
      const auto first = fit::internal::point_errors(track, a),
                 second = fit::internal::point_errors(track, b);
      double slow = 0;
      for (const fit::SlowError& s : track.slow)
        slow += s.sd * s.sd * std::exp(-std::abs(track.time[a] - track.time[b]) / s.time);
      v.block<2, 2>(2 * i, 2 * j) = first.slow * second.slow * slow * Eigen::Matrix2d::Identity();
      if (i == j) v.block<2, 2>(2 * i, 2 * i) += first.own + added * Eigen::Matrix2d::Identity();
    }
  return v;
}

}  // namespace tribotrack::test
