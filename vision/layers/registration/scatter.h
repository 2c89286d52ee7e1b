// How much a position scatters, by the residuals themselves.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace tribotrack::vision {

/// What each cluster of a frame's pixels does to its position, i_c = N^-1 s_c with s_c the sum of w J r over
/// it, px. The position's error is their sum; where clusters err independently its covariance is the sum over
/// them of i_c i_c^T [Liang and Zeger, Biometrika 73 (1986) 13], whatever the weights are.
using ClusterPulls = std::vector<Eigen::Vector2f>;

/// Over a run of frames, about each cluster's mean: what stays the same for the whole run moves all its
/// positions alike, which is no error of a displacement.
struct RunScatter {
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  ///< of a position, px^2
  double white = 0;        ///< variance of a coordinate by the change from one frame to the next, px^2
  double slow = 0;         ///< what the covariance has beyond it
  double slow_frames = 0;  ///< over how many frames that stays alike: the integral of its correlation
};

/// `taken`: the share of the squares that the position has taken, along x and y.
RunScatter run_scatter(const std::vector<ClusterPulls>& frames, const Eigen::Array2d& taken);

}  // namespace tribotrack::vision
