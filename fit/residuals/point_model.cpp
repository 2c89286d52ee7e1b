#include "fit/residuals/point_model.h"

#include <algorithm>
#include <cmath>

#include "model/trajectory.h"

namespace tribotrack::fit::internal {
namespace {

/// The platform in the camera's frame, `seen` its share that an exposure leaves, and by A, A_y, w and its
/// phase.
void add_platform(const model::Scenario& scenario, double time, double seen,
                  const std::vector<model::Parameter>& wanted, Eigen::Index k, Eigen::Matrix2Xd& positions,
                  Eigen::MatrixXd* jacobian) {
  const auto& drive = scenario.drive;
  const double phase = scenario.start_phase + drive.angular_frequency * time;
  positions.col(k) += seen * drive.displacement(phase);
  if (!jacobian) return;
  const double slope_x = -seen * drive.amplitude * std::sin(phase),
               slope_y = -seen * drive.amplitude_y * std::sin(phase + drive.phase_shift);
  for (std::size_t j = 0; j < wanted.size(); ++j) {
    const auto column = static_cast<Eigen::Index>(j);
    double &x = (*jacobian)(2 * k, column), &y = (*jacobian)(2 * k + 1, column);
    switch (wanted[j]) {
      case model::Parameter::amplitude:
        x += seen * std::cos(phase);
        break;
      case model::Parameter::amplitude_y:
        y += seen * std::cos(phase + drive.phase_shift);
        break;
      case model::Parameter::angular_frequency:
        x += slope_x * time;
        y += slope_y * time;
        break;
      case model::Parameter::start_phase:
        x += slope_x;
        y += slope_y;
        break;
      default:
        break;
    }
  }
}

}  // namespace

PointModel model_points(const Unknowns& unknowns, const AppliedScenario& applied,
                        const std::vector<double>& times, const Seen& seen, double tolerance,
                        bool derivatives) {
  model::Scenario scenario = applied.scenario;
  scenario.duration = times.back();
  model::IntegrationOptions options;
  options.tolerance = tolerance;
  if (derivatives) options.derivatives = applied.wanted;
  const model::Trajectory trajectory = model::integrate(scenario, options);
  const bool sensitive = !options.derivatives.empty();

  PointModel points;
  Eigen::MatrixXd by_wanted;
  trajectory.positions_at(times, seen.exposure, points.positions, sensitive ? &by_wanted : nullptr);
  if (seen.camera_frame) {
    const double half = 0.5 * scenario.drive.angular_frequency * seen.exposure;
    const double share = half > 0 ? std::sin(half) / half : 1;
    for (std::size_t i = 0; i < times.size(); ++i)
      add_platform(scenario, times[i], share, applied.wanted, static_cast<Eigen::Index>(i), points.positions,
                   sensitive ? &by_wanted : nullptr);
  }
  points.positions /= applied.scale;
  if (!derivatives) return points;
  if (sensitive)
    points.jacobian.noalias() = by_wanted * (applied.chain / applied.scale);
  else
    points.jacobian.setZero(2 * points.positions.cols(), applied.chain.cols());
  if (const auto scale = unknowns.find(FitParameter::scale))
    points.jacobian.col(*scale) -= points.positions.reshaped() / applied.scale;
  return points;
}

}  // namespace tribotrack::fit::internal
