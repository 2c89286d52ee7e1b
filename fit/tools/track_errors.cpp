#include "fit/tools/track_errors.h"

#include <algorithm>
#include <cmath>

#include "fit/tools/dense.h"

namespace tribotrack::fit::internal {
double slow_variance(const TrackTable& track, double apart) {
  double sum = 0;
  for (const SlowError& slow : track.slow) sum += slow.sd * slow.sd * std::exp(-apart / slow.time);
  return sum;
}

double mean_variance(const TrackTable& track) {
  double sum = 0;
  for (const Eigen::Matrix2d& covariance : track.covariance) sum += 0.5 * covariance.trace();
  return sum / static_cast<double>(track.covariance.size());
}

PointErrors point_errors(const TrackTable& track, std::size_t i) {
  PointErrors point{track.covariance[i]};
  const double slow = slow_variance(track, 0);
  if (!(slow > 0)) return point;
  point.slow = std::sqrt(std::min(1.0, std::max(0.0, eigenvalues(point.own)(0)) / slow));
  point.own -= point.slow * point.slow * slow * Eigen::Matrix2d::Identity();
  return point;
}

Eigen::Matrix2d covariance_of_sum(const TrackTable& track, const WeightedPoints& sum) {
  std::vector<PointErrors> errors;
  for (const auto& [point, weight] : sum) errors.push_back(point_errors(track, point));
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
  for (std::size_t a = 0; a < sum.size(); ++a) {
    const auto& [i, weight] = sum[a];
    for (std::size_t b = 0; b < sum.size(); ++b) {
      const auto& [j, other] = sum[b];
      if (i == j) covariance += weight * other * errors[a].own;
      if (!track.slow.empty())
        covariance += weight * other * errors[a].slow * errors[b].slow *
                      slow_variance(track, std::abs(track.time[i] - track.time[j])) *
                      Eigen::Matrix2d::Identity();
    }
  }
  return covariance;
}

}  // namespace tribotrack::fit::internal
