// Where a run of many cycles ends, from its first few.
#pragma once

#include <Eigen/Core>

#include "model/trajectory.h"

namespace tribotrack::fit::internal {

struct EndPoint {
  Eigen::Vector2d position = Eigen::Vector2d::Zero();  ///< m
  Eigen::Matrix2Xd jacobian;                           ///< at a fixed end time; empty for a plain run
  int cycles = 0;                                      ///< solved; the rest repeat the last of them
};

/// The velocity's flow is a contraction: two starts under one drive never separate. So the velocities one
/// cycle apart bound how much any later cycle can differ from the last one solved, and the displacement of k
/// further cycles is k times its own, to within P |u(t) - u(t - P)| k^2/2 (P: one period). Where that is
/// below `tolerance` of the path, the further cycles are not solved; how many are enough is guessed from the
/// friction's damping, and a guess that fails is paid with the whole run. Derivatives by parameters settle as
/// fast and grow by the same amount every cycle, those by w included.
EndPoint settled_end(const model::Scenario& scenario, const model::IntegrationOptions& options);

}  // namespace tribotrack::fit::internal
