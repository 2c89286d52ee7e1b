// Every tracked point against the model's dense trajectory. The start point is linear: it is projected out,
// so that it costs no unknown and is counted exactly.
#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <Eigen/QR>
#include <cmath>

#include "fit/internal/residuals.h"
#include "model/trajectory.h"

namespace tribotrack::fit::internal {
namespace {

constexpr double kFinestSigma = 1e-9;  ///< m; no camera sees less

/// The platform in the camera's frame, and by A, A_y and w.
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

void Residuals::modelled_points(const Eigen::VectorXd& values, std::size_t index, Eigen::Matrix2Xd& positions,
                                Eigen::MatrixXd* jacobian) const {
  const TrajectoryRun& run = problem_->trajectory_runs[index];
  const std::size_t first = first_point_[index], n = point_count(index);
  AppliedScenario applied = run.free_slide ? unknowns_->apply_free_slide(values, index, jacobian != nullptr)
                                           : unknowns_->apply_trajectory(values, index, jacobian != nullptr);
  const double origin = run.track.time[first];
  applied.scenario.duration = run.track.time.back() - origin;
  model::IntegrationOptions options;
  options.derivatives = applied.wanted;
  options.tolerance = tolerance_;
  const model::Trajectory trajectory = model::integrate(applied.scenario, options);
  const bool camera_frame = !run.free_slide && !run.track.platform_frame;

  positions.resize(2, static_cast<Eigen::Index>(n));
  if (jacobian) jacobian->setZero(2 * static_cast<Eigen::Index>(n), unknowns_->size());
  const auto scale = unknowns_->find(FitParameter::scale);
  for (std::size_t i = 0; i < n; ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    const double time = std::min(run.track.time[first + i] - origin, trajectory.end_time());
    Eigen::Vector2d position;
    Eigen::Matrix2Xd by_wanted;
    if (jacobian && !applied.wanted.empty()) {
      model::SensitiveSample sample = trajectory.sensitive_at(time);
      position = sample.sample.position;
      by_wanted = std::move(sample.position_jacobian);
    } else {
      position = trajectory.at(time).position;
    }
    if (camera_frame)
      add_platform(applied.scenario, time, position, applied.wanted,
                   by_wanted.cols() > 0 ? &by_wanted : nullptr);
    positions.col(k) = position / applied.scale;
    if (!jacobian) continue;
    if (by_wanted.cols() > 0)
      jacobian->middleRows(2 * k, 2).noalias() = by_wanted * applied.chain / applied.scale;
    if (scale) jacobian->block(2 * k, *scale, 2, 1) -= positions.col(k) / applied.scale;
  }
}

void Residuals::trajectory(const Eigen::VectorXd& values, std::size_t index,
                           Eigen::Ref<Eigen::VectorXd> residuals, Eigen::MatrixXd* jacobian,
                           Eigen::Index row) const {
  const TrajectoryRun& run = problem_->trajectory_runs[index];
  const std::size_t first = first_point_[index], n = point_count(index);
  const auto& scatter = scatter_.trajectories[index];
  Eigen::Matrix2Xd positions;
  Eigen::MatrixXd by_unknowns;
  modelled_points(values, index, positions, jacobian ? &by_unknowns : nullptr);

  // Whitened residuals, their Jacobian, and the columns of the start point (W: residual = .. - W x0).
  const double added = scatter.between_points * scatter.between_points + kFinestSigma * kFinestSigma;
  const double uncorrelated = 1 / std::sqrt(scatter.correlation_time);
  Eigen::MatrixX2d start(2 * static_cast<Eigen::Index>(n), 2);
  for (std::size_t i = 0; i < n; ++i) {
    const auto k = 2 * static_cast<Eigen::Index>(i);
    const Eigen::LLT<Eigen::Matrix2d> factor(
        Eigen::Matrix2d(run.track.covariance[first + i] + added * Eigen::Matrix2d::Identity()));
    const Eigen::Vector2d difference =
        run.track.position[first + i] - positions.col(static_cast<Eigen::Index>(i));
    const double weight = uncorrelated * std::sqrt(point_weight(index, i));
    residuals.segment<2>(k) = weight * factor.matrixL().solve(difference);
    start.middleRows<2>(k) = weight * factor.matrixL().solve(Eigen::Matrix2d::Identity()).eval();
    if (jacobian)
      by_unknowns.middleRows(k, 2) = -weight * factor.matrixL().solve(by_unknowns.middleRows(k, 2)).eval();
  }
  const Eigen::HouseholderQR<Eigen::MatrixX2d> qr(start);
  const Eigen::MatrixX2d q = qr.householderQ() * Eigen::MatrixX2d::Identity(start.rows(), 2);
  residuals -= q * (q.transpose() * residuals).eval();
  if (jacobian)
    jacobian->middleRows(row, by_unknowns.rows()) = by_unknowns - q * (q.transpose() * by_unknowns);
}

PointResiduals Residuals::points(const Eigen::VectorXd& values, std::size_t index) const {
  const TrajectoryRun& run = problem_->trajectory_runs[index];
  const std::size_t first = first_point_[index], n = point_count(index);
  const double between = scatter_.trajectories[index].between_points;
  const double added = between * between + kFinestSigma * kFinestSigma;
  Eigen::Matrix2Xd positions;
  modelled_points(values, index, positions, nullptr);
  PointResiduals result;
  Eigen::Matrix2d weights = Eigen::Matrix2d::Zero();
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (std::size_t i = 0; i < n; ++i) {
    result.row.push_back(first + i);
    result.residual.push_back(run.track.position[first + i] - positions.col(static_cast<Eigen::Index>(i)));
    const Eigen::Matrix2d weight =
        point_weight(index, i) *
        (run.track.covariance[first + i] + added * Eigen::Matrix2d::Identity()).inverse();
    weights += weight;
    sum += weight * result.residual.back();
  }
  result.start_point = weights.ldlt().solve(sum);
  for (auto& residual : result.residual) residual -= result.start_point;
  return result;
}

}  // namespace tribotrack::fit::internal
