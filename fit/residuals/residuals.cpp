#include "fit/residuals/residuals.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "fit/estimate.h"
#include "fit/residuals/end_point.h"
#include "fit/residuals/free_slide.h"
#include "fit/tools/dense.h"
#include "fit/tools/statistics.h"
#include "model/parallel.h"
#include "model/trajectory.h"

namespace tribotrack::fit::internal {

Residuals::Residuals(const Unknowns& unknowns, int threads)
    : problem_(&unknowns.problem()), unknowns_(&unknowns), threads_(threads) {
  const Problem& problem = *problem_;
  rows_ = 2 * static_cast<Eigen::Index>(problem.summary_runs.size());
  for (const auto& run : problem.trajectory_runs) {
    first_point_.push_back(run.free_slide ? guess_free_slide(run).first : 0);
    rows_ += 2 * static_cast<Eigen::Index>(point_count(first_point_.size() - 1));
  }
  for (Eigen::Index i = 0; i < unknowns.common(); ++i)
    if (const auto prior = unknowns.prior(i)) priors_.emplace_back(i, *prior);
  for (std::size_t run = 0; run < problem.trajectory_runs.size(); ++run)
    if (const Eigen::Index phase = unknowns.phase_index(run); phase >= 0)
      priors_.emplace_back(phase, Prior{0, problem.trajectory_runs[run].start_phase_sd});
  const auto know = [&](Eigen::Index unknown, const Eigen::VectorXd& mean, const Eigen::MatrixXd& covariance,
                        Nuisance kind) {
    const Eigen::MatrixXd one = Eigen::MatrixXd::Identity(mean.size(), mean.size());
    joint_.push_back({unknown, mean, Factor(covariance).whitened(one), kind});
  };
  for (std::size_t run = 0; run < problem.trajectory_runs.size(); ++run) {
    if (const Eigen::Index own = unknowns.own_index(run); own >= 0) {
      const Eigen::MatrixXd& covariance = problem.trajectory_runs[run].own.covariance;
      know(own, Eigen::VectorXd::Zero(covariance.rows()), covariance, Nuisance::own);
    }
    if (const Eigen::Index spin = unknowns.spin_index(run); spin >= 0) {
      const DiscSpin& known = *problem.trajectory_runs[run].spin;
      know(spin, Eigen::Vector2d(known.rate, known.bearing), known.covariance, Nuisance::spin);
    }
    if (const Eigen::Index deviation = unknowns.deviation_index(run); deviation >= 0)
      priors_.emplace_back(deviation, Prior{0, problem.between_slides});
  }
  rows_ += prior_rows();
  scatter_.trajectories.resize(problem.trajectory_runs.size());
  prepared_.resize(problem.trajectory_runs.size());
  for (const auto& run : problem.trajectory_runs)
    if (!run.free_slide)
      reference_time_ = std::max(reference_time_, run.track.time.back() - run.track.time.front());
  prepare();
}

void Residuals::set_excess_variance(const ExcessVariance& scatter) {
  scatter_ = scatter;
  prepare();
}

void Residuals::set_weights(const Weights& weights) {
  weights_ = weights;
  prepare();
}

std::size_t Residuals::point_count(std::size_t run) const {
  return problem_->trajectory_runs[run].track.time.size() - first_point_[run];
}

Eigen::Index Residuals::trajectory_row(std::size_t run) const {
  std::size_t row = 2 * problem_->summary_runs.size();
  for (std::size_t i = 0; i < run; ++i) row += 2 * point_count(i);
  return static_cast<Eigen::Index>(row);
}

double Residuals::degrees_of_freedom() const {
  double dof = 2.0 * static_cast<double>(problem_->summary_runs.size()) + static_cast<double>(prior_rows()) -
               static_cast<double>(unknowns_->size());
  for (std::size_t i = 0; i < first_point_.size(); ++i)
    dof += 2.0 * static_cast<double>(point_count(i)) / scatter_.trajectories[i].correlation_time - 2;
  return dof;
}

double Residuals::excess(double chi2) const {
  const double dof = degrees_of_freedom();
  return dof > 0 ? std::max(1.0, chi2 / dof) : 1;
}

double Residuals::tolerance_for(double share, double coarsest) const {
  std::vector<double> relative;
  for (const auto& run : problem_->summary_runs) {
    const double sigma = std::sqrt(0.5 * run.measured.covariance.trace()) + scatter_.runs();
    relative.push_back(sigma / std::max(run.measured.vector.norm(), sigma));
  }
  for (std::size_t i = 0; i < problem_->trajectory_runs.size(); ++i) {
    const auto& track = problem_->trajectory_runs[i].track;
    const double sigma =
        std::sqrt(0.5 * track.covariance.front().trace()) + scatter_.trajectories[i].between_points;
    const double path = (track.position.back() - track.position.front()).norm();
    relative.push_back(sigma / std::max(path, sigma) / std::sqrt(static_cast<double>(track.time.size())));
  }
  return std::clamp(share * upper_median(relative), 1e-9, coarsest);
}

bool Residuals::evaluate(const Eigen::VectorXd& values, Eigen::VectorXd& residuals,
                         Eigen::MatrixXd* jacobian) const {
  residuals.setZero(rows_);
  if (jacobian) jacobian->setZero(rows_, unknowns_->size());
  const std::size_t summaries = problem_->summary_runs.size();
  try {
    parallel_for(summaries + first_point_.size(), threads_, [&](std::size_t i) {
      if (i < summaries) {
        const auto row = 2 * static_cast<Eigen::Index>(i);
        summary(values, i, residuals.segment(row, 2), jacobian, row);
      } else {
        const std::size_t run = i - summaries;
        const auto row = trajectory_row(run);
        trajectory(values, run, residuals.segment(row, 2 * static_cast<Eigen::Index>(point_count(run))),
                   jacobian, row);
      }
    });
  } catch (const model::InvalidParameter& no_motion) {
    failures_->add(values, no_motion.what());
    return false;
  } catch (const model::StepLimitExceeded& no_end) {
    failures_->add(values, no_end.what());
    return false;
  }
  if (common_) {
    whiten_common(residuals);
    if (jacobian)
      for (Eigen::Index j = 0; j < jacobian->cols(); ++j) whiten_common(jacobian->col(j));
  }
  Eigen::Index row = first_prior();
  for (const auto& [unknown, prior] : priors_) {
    residuals(row) = (values(unknown) - prior.mean) / prior.sd;
    if (jacobian) (*jacobian)(row, unknown) = 1 / prior.sd;
    ++row;
  }
  for (const JointPrior& prior : joint_) {
    const Eigen::Index n = prior.mean.size();
    residuals.segment(row, n) = prior.white * (values.segment(prior.unknown, n) - prior.mean);
    if (jacobian) jacobian->block(row, prior.unknown, n, n) = prior.white;
    row += n;
  }
  if (residuals.allFinite() && (!jacobian || jacobian->allFinite())) return true;
  failures_->add(values, "the modelled motion is not finite");
  return false;
}

Eigen::Index Residuals::prior_rows() const {
  auto rows = static_cast<Eigen::Index>(priors_.size());
  for (const JointPrior& prior : joint_) rows += prior.mean.size();
  return rows;
}

Eigen::Index Residuals::first_prior() const {
  return rows_ - prior_rows();
}

std::vector<Residuals::NuisancePrior> Residuals::nuisance_priors() const {
  std::vector<NuisancePrior> result;
  Eigen::Index row = first_prior();
  for (const auto& [unknown, prior] : priors_) {
    if (unknown >= unknowns_->common()) {
      bool deviation = false;
      for (std::size_t run = 0; run < problem_->trajectory_runs.size(); ++run)
        deviation = deviation || unknowns_->deviation_index(run) == unknown;
      result.push_back({row, 1, deviation ? Nuisance::deviation : Nuisance::phase});
    }
    ++row;
  }
  for (const JointPrior& prior : joint_) {
    result.push_back({row, prior.mean.size(), prior.kind});
    row += prior.mean.size();
  }
  return result;
}

double Residuals::chi2(const Eigen::VectorXd& values) const {
  Eigen::VectorXd residuals;
  return evaluate(values, residuals, nullptr) ? residuals.squaredNorm()
                                              : std::numeric_limits<double>::infinity();
}

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
