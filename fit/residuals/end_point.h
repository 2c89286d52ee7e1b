// Where a run ends, without its way there.
#pragma once

#include <Eigen/Core>

#include "model/trajectory.h"

namespace tribotrack::fit::internal {

struct EndPoint {
  Eigen::Vector2d position = Eigen::Vector2d::Zero();  ///< m
  Eigen::Matrix2Xd jacobian;                           ///< by `derivatives`; empty without
  long steps = 0;
};

inline EndPoint end_point(const model::Scenario& scenario, const std::vector<model::Parameter>& derivatives,
                          double tolerance, long max_steps = model::IntegrationOptions{}.max_steps) {
  model::IntegrationOptions options;
  options.max_steps = max_steps;
  options.derivatives = derivatives;
  options.tolerance = tolerance;
  options.dense = false;
  const model::Trajectory trajectory = model::integrate(scenario, options);
  if (derivatives.empty()) return {trajectory.end().position, {}, trajectory.summary().steps};
  model::SensitiveSample end = trajectory.sensitive_end();
  return {end.sample.position, std::move(end.position_jacobian), trajectory.summary().steps};
}

}  // namespace tribotrack::fit::internal
