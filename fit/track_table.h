// A track as the fit sees it: a plain table of numbers in SI, whatever tracker made it.
//
//   TrackTable track;
//   for (const auto& row : rows) {                       // in the order of time, lost rows left out
//     track.frame.push_back(row.frame);
//     track.time.push_back(row.time_s);                  // s
//     track.position.emplace_back(row.x_m, row.y_m);     // m, y up
//     track.covariance.push_back(row.sd_m * row.sd_m * Eigen::Matrix2d::Identity());
//   }
//   const Displacement moved = measure_displacement(track, {62.8, 0.01}, 20);   // fit/measurement.h
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace tribotrack::fit {

/// An error that changes slowly, of each coordinate by itself: stationary, of covariance
/// sd^2 exp(-|t - t'|/time) (Ornstein and Uhlenbeck, Phys. Rev. 36 (1930) 823).
struct SlowError {
  double sd = 0;    ///< m
  double time = 0;  ///< s, its correlation time
};

/// Tracked points in time order, measured rows only (lost ones are left out). Axes x right, y up, turned by
/// -xi_axis, so that x is the direction of xi in eq. (1).
struct TrackTable {
  std::vector<std::int64_t> frame;
  std::vector<double> time;               ///< s, 0 at the recording's first stored image
  std::vector<Eigen::Vector2d> position;  ///< m, relative to the first point
  std::vector<Eigen::Matrix2d>
      covariance;  ///< m^2, of each point: the sum of its own noise and of the slow errors below
  /// Degrees of freedom that each axis's variance is as good as known by, where it was estimated from these
  /// very points (PointNoise::dof); 0: it is known.
  double noise_dof = 0;
  std::vector<SlowError> slow;          ///< errors that neighbouring points share
  bool platform_frame = false;          ///< true: platform's motion subtracted; false: camera's frame
  std::vector<Eigen::Vector2d> marker;  ///< m, the marker in the camera's frame; empty without a marker
  std::vector<double> marker_sigma;     ///< m, per axis
  /// rad, how far the part has turned (its sense does not matter), with sd; NaN where that is not seen, empty
  /// in a track without.
  std::vector<double> angle, angle_sigma;
  bool round = false;   ///< the part is a disc: nothing bears beyond its radius
  double radius = 0;    ///< m, of the part's face; 0 where not known
  double exposure = 0;  ///< s, of every frame, centred on its time; 0 where not known
};

}  // namespace tribotrack::fit
