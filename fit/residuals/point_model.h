// The model's positions at the times a track was seen, with derivatives by the unknowns.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "fit/residuals/unknowns.h"
#include "model/trajectory.h"

namespace tribotrack::fit::internal {

struct PointModel {
  Eigen::Matrix2Xd positions;  ///< m, in the picture (divided by the scale)
  Eigen::MatrixXd jacobian;    ///< 2n x columns of the chain, x and y of a point below each other
};

/// How the points were seen.
struct Seen {
  bool camera_frame = false;  ///< the platform's own motion is in them
  double exposure = 0;        ///< s: a point is the mean over it
};

/// At `times` (s from the start). Throws as model::integrate(), beyond `max_steps` (a slide's are bounded)
/// too.
PointModel model_points(const Unknowns& unknowns, const AppliedScenario& applied,
                        const std::vector<double>& times, const Seen& seen, double tolerance,
                        bool derivatives, long max_steps = model::IntegrationOptions{}.max_steps);

}  // namespace tribotrack::fit::internal
