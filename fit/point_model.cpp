#include "fit/internal/point_model.h"

#include <algorithm>
#include <cmath>

#include "model/trajectory.h"

namespace tribotrack::fit::internal {
namespace {

/// The platform in the camera's frame, and by A, A_y, w and its phase.
void add_platform(const model::Scenario& scenario, double time, Eigen::Vector2d& position,
                  const std::vector<model::Parameter>& wanted, Eigen::Matrix2Xd* jacobian) {
  const auto& drive = scenario.drive;
  const double phase = scenario.start_phase + drive.angular_frequency * time;
  position += drive.displacement(phase);
  if (!jacobian) return;
  for (std::size_t j = 0; j < wanted.size(); ++j) {
    auto column = jacobian->col(static_cast<Eigen::Index>(j));
    switch (wanted[j]) {
      case model::Parameter::amplitude:
        column.x() += std::cos(phase);
        break;
      case model::Parameter::amplitude_y:
        column.y() += std::cos(phase + drive.phase_shift);
        break;
      case model::Parameter::angular_frequency:
        column.x() -= drive.amplitude * std::sin(phase) * time;
        column.y() -= drive.amplitude_y * std::sin(phase + drive.phase_shift) * time;
        break;
      case model::Parameter::start_phase:
        column.x() -= drive.amplitude * std::sin(phase);
        column.y() -= drive.amplitude_y * std::sin(phase + drive.phase_shift);
        break;
      default:
        break;
    }
  }
}

}  // namespace

PointModel model_points(const Unknowns& unknowns, const AppliedScenario& applied,
                        const std::vector<double>& times, bool camera_frame, double tolerance,
                        bool derivatives) {
  model::Scenario scenario = applied.scenario;
  scenario.duration = times.back();
  model::IntegrationOptions options;
  options.tolerance = tolerance;
  if (derivatives) options.derivatives = applied.wanted;
  const model::Trajectory trajectory = model::integrate(scenario, options);
  const bool sensitive = !options.derivatives.empty();

  PointModel points;
  points.positions.resize(2, static_cast<Eigen::Index>(times.size()));
  if (derivatives) points.jacobian.setZero(2 * static_cast<Eigen::Index>(times.size()), applied.chain.cols());
  const auto scale = unknowns.find(FitParameter::scale);
  for (std::size_t i = 0; i < times.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    const double time = std::min(times[i], trajectory.end_time());
    Eigen::Vector2d position;
    Eigen::Matrix2Xd by_wanted;
    if (sensitive) {
      model::SensitiveSample sample = trajectory.sensitive_at(time);
      position = sample.sample.position;
      by_wanted = std::move(sample.position_jacobian);
    } else {
      position = trajectory.at(time).position;
    }
    if (camera_frame)
      add_platform(scenario, time, position, applied.wanted, sensitive ? &by_wanted : nullptr);
    points.positions.col(k) = position / applied.scale;
    if (!derivatives) continue;
    if (sensitive) points.jacobian.middleRows(2 * k, 2).noalias() = by_wanted * applied.chain / applied.scale;
    if (scale) points.jacobian.block(2 * k, *scale, 2, 1) -= points.positions.col(k) / applied.scale;
  }
  return points;
}

}  // namespace tribotrack::fit::internal
