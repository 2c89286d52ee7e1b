// Errors of a track whose truth is known.
#pragma once

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <vector>

#include "vision/track.h"

namespace tribotrack::vision::test {

/// Of the points said to be ok, their mean offset removed.
struct TrackErrors {
  int count = 0;
  double rms = 0;           ///< of the components, px
  double sd = 0;            ///< as stated, rms of the components, px
  double standardised = 0;  ///< rms of e^T C^-1 e / 2
  double worst = 0;         ///< largest of a point, in its own sd
  double drift = 0;         ///< mean of the last tenth minus that of the first, px
};

inline TrackErrors errors_of(const Track& track, const std::function<Point(std::int64_t frame)>& truth) {
  std::vector<Eigen::Vector2d> errors;
  std::vector<Eigen::Matrix2d> stated;
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const TrackPoint& p : track.points) {
    if (p.status != TrackStatus::ok) continue;
    const Point t = truth(p.frame);
    errors.emplace_back(p.x - t.x, p.y - t.y);
    const double c = p.rho_xy * p.sigma_x * p.sigma_y;
    stated.push_back(Eigen::Matrix2d{{p.sigma_x * p.sigma_x, c}, {c, p.sigma_y * p.sigma_y}});
    mean += errors.back();
  }
  TrackErrors out;
  out.count = static_cast<int>(errors.size());
  if (errors.empty()) return out;
  mean /= out.count;
  const std::size_t tenth = errors.size() / 10;
  Eigen::Vector2d drift = Eigen::Vector2d::Zero();
  for (std::size_t k = 0; k < errors.size(); ++k) {
    const Eigen::Vector2d e = errors[k] - mean;
    const double squares = e.dot(stated[k].inverse() * e);
    out.rms += e.squaredNorm() / (2 * out.count);
    out.sd += stated[k].trace() / (2 * out.count);
    out.standardised += squares / (2 * out.count);
    out.worst = std::max(out.worst, std::sqrt(squares));
    if (k < tenth) drift -= e / static_cast<double>(tenth);
    if (k >= errors.size() - tenth) drift += e / static_cast<double>(tenth);
  }
  out.rms = std::sqrt(out.rms);
  out.sd = std::sqrt(out.sd);
  out.standardised = std::sqrt(out.standardised);
  out.drift = drift.norm();
  return out;
}

}  // namespace tribotrack::vision::test
