#include "fit/residuals/residuals.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "fit/residuals/end_point.h"
#include "fit/residuals/free_slide.h"
#include "fit/tools/dense.h"
#include "fit/tools/statistics.h"
#include "model/parallel.h"

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
                        bool derivatives, long max_steps) {
  model::Scenario scenario = applied.scenario;
  scenario.duration = times.back();
  model::IntegrationOptions options;
  options.tolerance = tolerance;
  options.max_steps = std::min(max_steps, unknowns.most_steps(scenario));
  if (derivatives) options.derivatives = applied.wanted;
  const bool sensitive = !options.derivatives.empty();
  PointModel points;
  Eigen::MatrixXd by_wanted;
  const model::Trajectory motion = model::integrate(scenario, options);
  motion.positions_at(times, seen.exposure, points.positions, sensitive ? &by_wanted : nullptr);
  points.steps = motion.summary().steps;
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

Residuals::Residuals(const Unknowns& unknowns, int threads)
    : problem_(&unknowns.problem()), unknowns_(&unknowns), threads_(threads) {
  for (Eigen::Index i = 0; i < unknowns.common(); ++i)
    if (const auto prior = unknowns.prior(i)) priors_.emplace_back(i, *prior);
  differentiated_ = unknowns.shared();
  own_.assign(problem_->summary_runs.size(), Eigen::Matrix2d::Zero());
  for (const auto& run : problem_->trajectory_runs) {
    first_point_.push_back(run.free_slide ? guess_free_slide(run).first : 0);
    if (!run.free_slide)
      reference_time_ = std::max(reference_time_, run.track.time.back() - run.track.time.front());
  }
  excess_.trajectories.resize(first_point_.size());
  tracks_.resize(first_point_.size());
  const auto data = static_cast<Eigen::Index>(2 * own_.size());
  layout_.groups.push_back({data, data + static_cast<Eigen::Index>(priors_.size()), {unknowns.common(), 0}});
  prepare();
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    const auto points = 2 * static_cast<Eigen::Index>(tracks_[i]->points());
    layout_.groups.push_back({points, points, unknowns.own(i)});
    for (const NuisanceBlock& block : unknowns.nuisances(i)) layout_.groups.back().rows += block.known.rows();
  }
}

void Residuals::set_excess_variance(const ExcessVariance& excess) {
  excess_ = excess;
  prepare();
}

bool Residuals::linearise(const Eigen::VectorXd& values) {
  if (!has_linear_terms(*unknowns_)) return true;
  if (terms_ && terms_->values() == values) return true;
  auto terms = LinearTerms::at(*unknowns_, values, tolerance_, threads_);
  if (!terms) return false;
  terms_ = std::make_shared<const LinearTerms>(std::move(*terms));
  differentiated_ = linear_unknowns(*unknowns_, false);
  return true;
}

void Residuals::prepare() {
  parallel_for(tracks_.size(), threads_, [&](std::size_t i) {
    tracks_[i] =
        std::make_shared<TrackWhitening>(problem_->trajectory_runs[i], first_point_[i],
                                         excess_.trajectories[i], excess_.correlated, reference_time_);
  });
}

Eigen::Index RowLayout::rows() const {
  Eigen::Index sum = 0;
  for (const Group& group : groups) sum += group.rows;
  return sum;
}

double Residuals::degrees_of_freedom() const {
  double dof = static_cast<double>(layout_.rows() - unknowns_->size());
  for (const SummaryRun& run : problem_->summary_runs) dof -= run.held_out ? 2 : 0;
  for (std::size_t i = 0; i < tracks_.size(); ++i)
    dof +=
        2.0 * static_cast<double>(tracks_[i]->points()) * (1 / excess_.trajectories[i].correlation_time - 1) -
        2;
  return dof;
}

double Residuals::noise_degrees_of_freedom() const {
  const auto all = static_cast<double>(layout_.rows());
  double inverse = 0;
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    const double share = 2 * static_cast<double>(tracks_[i]->points()) / all;
    const double own = 2 * problem_->trajectory_runs[i].track.noise_dof;  // of two axes
    if (own > 0) inverse += share * share / own;
  }
  return 1 / inverse;
}

double Residuals::p_value(double chi2, int more) const {
  return chi2_survival(chi2, degrees_of_freedom() - more, noise_degrees_of_freedom());
}

double Residuals::excess(double chi2) const {
  const double dof = degrees_of_freedom();
  return dof > 0 ? std::max(1.0, chi2 / dof) : 1;
}

double Residuals::tolerance_for(double share, double coarsest) const {
  // What the errors of many runs make of chi^2 grows with the root of their number.
  constexpr double kFew = 16;
  const double of_many = std::sqrt(std::max(1.0, static_cast<double>(problem_->summary_runs.size()) / kFew));
  std::vector<double> relative;
  for (const auto& run : problem_->summary_runs) {
    const double sigma = std::sqrt(0.5 * run.measured.covariance.trace()) + excess_.runs;
    relative.push_back(sigma / std::max(run.measured.vector.norm(), sigma) / of_many);
  }
  for (std::size_t i = 0; i < problem_->trajectory_runs.size(); ++i) {
    const auto& track = problem_->trajectory_runs[i].track;
    const double sigma =
        std::sqrt(0.5 * track.covariance.front().trace()) + excess_.trajectories[i].between_points;
    const double path = (track.position.back() - track.position.front()).norm();
    relative.push_back(sigma / std::max(path, sigma) / std::sqrt(static_cast<double>(track.time.size())));
  }
  return std::clamp(share * upper_median(relative), 1e-9, coarsest);
}

std::optional<Linearised> Residuals::at(const Eigen::VectorXd& values, bool derivatives,
                                        std::string* why) const {
  const auto none = [&](const std::string& reason) -> std::optional<Linearised> {
    if (why) *why = reason;
    return std::nullopt;
  };
  Linearised result;
  result.groups.resize(1 + tracks_.size());
  RowGroup& shared = result.groups.front();
  const Eigen::Index rows = layout_.groups.front().rows;
  shared.residuals.resize(rows);
  shared.shared.setZero(rows, derivatives ? unknowns_->common() : 0);
  shared.own.resize(rows, 0);
  const std::size_t summaries = problem_->summary_runs.size();
  try {
    parallel_for(summaries + tracks_.size(), threads_, [&](std::size_t i) {
      if (i < summaries)
        summary(values, i, derivatives, shared);
      else
        result.groups[1 + i - summaries] = trajectory(values, i - summaries, derivatives);
    });
  } catch (const model::InvalidParameter& no_motion) {
    return none(no_motion.what());
  } catch (const model::StepLimitExceeded& no_end) {
    return none(no_end.what());
  }
  auto row = static_cast<Eigen::Index>(2 * summaries);
  for (const auto& [unknown, prior] : priors_) {
    shared.residuals(row) = (values(unknown) - prior.mean) / prior.sd;
    if (derivatives) shared.shared(row, unknown) = 1 / prior.sd;
    ++row;
  }
  for (std::size_t g = 0; g < shift_.size(); ++g) {
    Eigen::VectorXd shift = shift_[g];
    for (std::size_t i = 0; g == 0 && i < summaries; ++i)
      shift.segment<2>(2 * static_cast<Eigen::Index>(i)) *= std::sqrt(weight(i));
    result.groups[g].residuals += shift;
  }
  if (result.finite()) return result;
  return none("the modelled motion is not finite");
}

double Residuals::chi2(const Eigen::VectorXd& values) const {
  const auto here = at(values, false);
  return here ? here->chi2() : std::numeric_limits<double>::infinity();
}

Eigen::Matrix2d Residuals::covariance(std::size_t index) const {
  return problem_->summary_runs[index].measured.covariance + own_[index] +
         excess_.runs * excess_.runs * Eigen::Matrix2d::Identity();
}

void Residuals::set_own_errors(const Eigen::VectorXd& values) {
  for (std::size_t i = 0; i < own_.size(); ++i) {
    const SummaryRun& run = problem_->summary_runs[i];
    own_[i].setZero();
    if (run.own.parameters.empty()) continue;
    const AppliedScenario applied = unknowns_->apply_summary(values, run, {});
    try {
      const Eigen::Matrix2Xd moved = end_point(applied.scenario, run.own.parameters, tolerance_).jacobian *
                                     (applied.stretch / applied.scale);
      own_[i] = moved * run.own.covariance * moved.transpose();
      own_[i] += 0.5 * run.own.bent * run.own.bent * own_[i].trace() * Eigen::Matrix2d::Identity();
    } catch (const model::InvalidParameter&) {  // no motion there: nothing to move
    } catch (const model::StepLimitExceeded&) {
    }
  }
}

Eigen::Vector2d Residuals::difference(const Linearised& at, std::size_t index) const {
  return Factor2(covariance(index)).lower() *
         at.groups.front().residuals.segment<2>(2 * static_cast<Eigen::Index>(index)) / root_of_weight(index);
}

Eigen::Matrix2Xd Residuals::derivatives(const Linearised& at, std::size_t index) const {
  return -Factor2(covariance(index)).lower() *
         at.groups.front().shared.middleRows(2 * static_cast<Eigen::Index>(index), 2) / root_of_weight(index);
}

double Residuals::root_of_weight(std::size_t index) const {
  constexpr double kHeldOut = 1e-6;
  return problem_->summary_runs[index].held_out ? kHeldOut : std::sqrt(weight(index));
}

void Residuals::summary(const Eigen::VectorXd& values, std::size_t index, bool derivatives,
                        RowGroup& group) const {
  const SummaryRun& run = problem_->summary_runs[index];
  const auto row = 2 * static_cast<Eigen::Index>(index);
  const Factor2 factor(covariance(index));
  ModelledDisplacement modelled;
  if (terms_ && terms_->values() == values) {
    modelled = terms_->here(index);
  } else {
    modelled = modelled_displacement(*unknowns_, terms_ ? terms_->held(values) : values, run,
                                     derivatives ? differentiated_ : std::vector<Eigen::Index>{}, tolerance_);
    if (terms_) terms_->add(index, values, modelled);
  }
  const double root = root_of_weight(index);
  group.residuals.segment<2>(row) = root * factor.whitened(run.measured.vector - modelled.position);
  if (!derivatives) return;
  group.shared.middleRows(row, 2) = -root * factor.whiten_columns(modelled.jacobian);
}

PointModel Residuals::modelled_points(const Eigen::VectorXd& values, std::size_t index,
                                      bool derivatives) const {
  const TrajectoryRun& run = problem_->trajectory_runs[index];
  const AppliedScenario applied = unknowns_->apply_trajectory(values, index, derivatives);
  const Seen seen{!run.free_slide && !run.track.platform_frame, run.track.exposure};
  PointModel modelled =
      model_points(*unknowns_, applied, tracks_[index]->times(), seen, tolerance_, derivatives);
  if (terms_) terms_->add(index, values, modelled.positions, modelled.jacobian);
  return modelled;
}

RowGroup Residuals::trajectory(const Eigen::VectorXd& values, std::size_t index, bool derivatives) const {
  const TrackWhitening& track = *tracks_[index];
  const PointModel modelled = modelled_points(values, index, derivatives);
  const Range own = unknowns_->own(index);
  const Eigen::Index rows = layout_.groups[1 + index].rows, shared = derivatives ? unknowns_->common() : 0;
  Eigen::Index row = modelled.positions.size();
  RowGroup group{Eigen::VectorXd(rows), Eigen::MatrixXd::Zero(rows, shared),
                 Eigen::MatrixXd::Zero(rows, derivatives ? own.count : 0), own.first};
  group.residuals.head(row) = track.whitened(track.difference(modelled.positions));
  if (derivatives) {
    const Eigen::MatrixXd whitened = track.whitened(-modelled.jacobian);
    group.shared.topRows(row) = whitened.leftCols(shared);
    group.own.topRows(row) = whitened.rightCols(own.count);
  }
  for (const NuisanceBlock& block : unknowns_->nuisances(index)) {
    if (block.known.size() == 0) continue;
    const Eigen::Index n = block.size();
    group.residuals.segment(row, n) = block.known * (values.segment(block.first, n) - block.guess);
    if (derivatives) group.own.block(row, block.first - own.first, n, n) = block.known;
    row += n;
  }
  return group;
}

PointResiduals Residuals::points(const Eigen::VectorXd& values, std::size_t index) const {
  return tracks_[index]->explained(modelled_points(values, index, false).positions);
}

}  // namespace tribotrack::fit::internal
