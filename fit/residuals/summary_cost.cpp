// Displacement vectors: two whitened residuals a run.
#include <cmath>

#include "fit/estimate.h"
#include "fit/residuals/end_point.h"
#include "fit/residuals/residuals.h"
#include "fit/tools/dense.h"
#include "model/trajectory.h"

namespace tribotrack::fit::internal {

Eigen::Matrix2d Residuals::covariance(std::size_t index) const {
  const Displacement& measured = problem_->summary_runs[index].measured;
  const Eigen::Matrix2d known = measured.covariance + own_error(index);
  const double along = scatter_.along * scatter_.along, across = scatter_.across * scatter_.across;
  const double length = measured.vector.norm();
  if (!(length > 0))  // no direction
    return known + std::max(along, across) * Eigen::Matrix2d::Identity();
  const Eigen::Vector2d u = measured.vector / length;
  return known + across * Eigen::Matrix2d::Identity() + (along - across) * u * u.transpose();
}

void Residuals::set_own_errors(const Eigen::VectorXd& values) {
  own_.assign(problem_->summary_runs.size(), Eigen::Matrix2d::Zero());
  for (std::size_t i = 0; i < own_.size(); ++i) {
    const SummaryRun& run = problem_->summary_runs[i];
    if (run.own.parameters.empty()) continue;
    const AppliedScenario applied = unknowns_->apply_summary(values, run, false);
    try {
      const Eigen::Matrix2Xd moved = end_point(applied.scenario, run.own.parameters, tolerance_).jacobian *
                                     (applied.stretch / applied.scale);
      own_[i] = moved * run.own.covariance * moved.transpose();
    } catch (const model::InvalidParameter&) {  // no motion there: nothing to move
    } catch (const model::StepLimitExceeded&) {
    }
  }
}

Eigen::Matrix2d Residuals::own_error(std::size_t index) const {
  return own_.empty() ? Eigen::Matrix2d::Zero().eval() : own_[index];
}

Eigen::Vector2d Residuals::difference(const Eigen::VectorXd& whitened, std::size_t index) const {
  return Factor2(covariance(index)).lower() * whitened.segment<2>(2 * static_cast<Eigen::Index>(index)) /
         std::sqrt(run_weight(index));
}

void Residuals::summary(const Eigen::VectorXd& values, std::size_t index,
                        Eigen::Ref<Eigen::VectorXd> residuals, Eigen::MatrixXd* jacobian,
                        Eigen::Index row) const {
  const SummaryRun& run = problem_->summary_runs[index];
  const auto applied = unknowns_->apply_summary(values, run, jacobian != nullptr);
  const Factor2 factor(covariance(index));
  const EndPoint end = end_point(applied.scenario, applied.wanted, tolerance_);
  // (measured - modelled / scale): dividing the model keeps the covariance, and with it the minimum, free of
  // the scale.
  const Eigen::Vector2d position = end.position * applied.stretch / applied.scale;
  const double root = std::sqrt(run_weight(index));
  residuals = root * factor.whitened(run.measured.vector - position);
  if (!jacobian) return;
  Eigen::MatrixXd by_unknowns = Eigen::MatrixXd::Zero(2, unknowns_->size());
  if (!applied.wanted.empty())
    by_unknowns = -(end.jacobian * applied.chain) * (applied.stretch / applied.scale);
  if (const auto scale = unknowns_->find(FitParameter::scale))
    by_unknowns.col(*scale) += position / applied.scale;
  if (const auto w = unknowns_->find(FitParameter::angular_frequency); w && run.measured.given_as_velocity)
    by_unknowns.col(*w) -= position / values(*w);
  jacobian->middleRows(row, 2) = root * factor.whiten_columns(by_unknowns);
}

}  // namespace tribotrack::fit::internal
