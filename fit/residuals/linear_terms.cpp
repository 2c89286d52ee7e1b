#include "fit/residuals/linear_terms.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>
#include <utility>

#include "fit/residuals/end_point.h"
#include "model/parallel.h"
#include "model/rival_laws.h"
#include "model/trajectory.h"

namespace tribotrack::fit::internal {
namespace {

/// Of motions that are subtracted from each other: their errors cancel for the most part.
constexpr double kTolerance = 1.5e-5;

/// A step far above the integration's error over which a displacement is still linear.
double step_of(FitParameter law) {
  return law == FitParameter::viscous ? 0.01 : law == FitParameter::gate_edges ? 0.001 : 0.002;
}

/// A search that strays beyond all sense (w of 1e26 rad/s) would integrate without end: there is no motion
/// then. Ordinary motion takes 5 to 10 steps a turn, along a line up to 112.
long most_steps(const Unknowns& unknowns, const model::Scenario& scenario) {
  constexpr double kAnyway = 10'000, kATurn = 1000;
  const double turns = scenario.end_time() * unknowns.reference_frequency() / (2 * std::numbers::pi);
  const auto most = static_cast<double>(model::IntegrationOptions{}.max_steps);
  return std::lround(std::min(kAnyway + kATurn * turns, most));
}

model::RivalLaw law_at(const Unknowns& unknowns, const Eigen::VectorXd& values) {
  const auto of = [&](FitParameter law) {
    const auto i = unknowns.find(law);
    return i ? values(*i) : 0;
  };
  return {.stribeck = of(FitParameter::stribeck),
          .viscous = of(FitParameter::viscous),
          .rise = std::sqrt(of(FitParameter::gate_edges)) / unknowns.reference_frequency(),
          .mu2_speed = of(FitParameter::mu2_speed),
          .static_friction = of(FitParameter::static_friction)};
}

/// What laws add to a run's displacement, and its derivatives.
struct AddedByLaws {
  Eigen::Vector2d added = Eigen::Vector2d::Zero();
  Eigen::Matrix2Xd by_laws;  ///< by the laws among the unknowns
  Eigen::Matrix2Xd bend;     ///< by the others
};

/// The derivatives of what laws add, with the chain from the run's friction to the unknowns.
Eigen::Matrix2Xd bend_of(const AppliedScenario& applied, const Eigen::Vector2d& added,
                         const Eigen::Matrix2d& by_mu) {
  Eigen::Matrix2Xd bend = Eigen::Matrix2Xd::Zero(2, applied.chain.cols());
  const model::Drive& drive = applied.scenario.drive;
  // epsilon = +pi/2 circles clockwise: a later pulse turns the drift by -lag. Along a line it does not.
  const double turning = -std::sin(drive.phase_shift) * std::min(drive.amplitude, drive.amplitude_y) /
                         std::max({drive.amplitude, drive.amplitude_y, 1e-300});
  for (std::size_t i = 0; i < applied.wanted.size(); ++i) {
    const Eigen::RowVectorXd chain = applied.chain.row(static_cast<Eigen::Index>(i));
    if (applied.wanted[i] == model::Parameter::mu1) bend += by_mu.col(0) * chain;
    if (applied.wanted[i] == model::Parameter::mu2) bend += by_mu.col(1) * chain;
    if (applied.wanted[i] == model::Parameter::lag)
      bend += turning * Eigen::Vector2d(-added.y(), added.x()) * chain;
  }
  return bend;
}

/// What the laws at `values` add to a run's displacement `by_paper`.
AddedByLaws added_by_laws(const Unknowns& unknowns, const Eigen::VectorXd& values, const SummaryRun& run,
                          const ModelledDisplacement& by_paper, const std::vector<Eigen::Index>& laws) {
  AddedByLaws result;
  result.by_laws.setZero(2, static_cast<Eigen::Index>(laws.size()));
  result.bend.setZero(2, unknowns.common());
  const AppliedScenario applied = unknowns.apply_summary(values, run, true);
  if (applied.scenario.start != model::Start::rest) return result;  // other laws are integrated from rest
  const double unit = applied.stretch / applied.scale;
  // Edges that take a negative time undo what positive ones add, so that chi^2 has no kink at 0.
  const auto edges = unknowns.find(FitParameter::gate_edges);
  const bool undone = edges && values(*edges) < 0;
  Eigen::VectorXd sharp = values, soft = values;
  if (undone) sharp(*edges) = 0, soft(*edges) = -values(*edges);
  const model::RivalLaw paper, as_sharp = law_at(unknowns, sharp), as_soft = law_at(unknowns, soft);
  std::vector<model::RivalLaw> beside{paper, as_sharp, as_soft};
  for (const Eigen::Index law : laws) {
    Eigen::VectorXd more = law == edges ? soft : sharp;
    more(law) += step_of(unknowns.parameter(law));
    beside.push_back(law_at(unknowns, more));
  }
  constexpr double kStep = 2e-3;  // of mu
  std::array<model::RivalLaw, 3> heavier{as_sharp, as_sharp, as_sharp};
  heavier[1].mu1 = heavier[2].mu2 = kStep;
  const bool together = beside.size() + 2 <= model::kMostRivalLaws;
  if (together) beside.insert(beside.end(), heavier.begin() + 1, heavier.end());
  static_assert(3 + kLaws.size() <= model::kMostRivalLaws);
  const auto under = [&](std::span<const model::RivalLaw> all) {
    return Eigen::Matrix2Xd(unit * model::rival_displacements(applied.scenario, all, kTolerance));
  };
  const Eigen::Matrix2Xd moved = under(beside);
  for (std::size_t k = 0; k < laws.size(); ++k)
    result.by_laws.col(static_cast<Eigen::Index>(k)) =
        (moved.col(static_cast<Eigen::Index>(3 + k)) - moved.col(laws[k] == edges ? 2 : 1)) /
        step_of(unknowns.parameter(laws[k]));
  if (as_soft == paper) return result;
  result.added = 2 * moved.col(1) - moved.col(2) - moved.col(0);

  // Differences of one integration: its errors cancel.
  const Eigen::Matrix2Xd there = together ? moved : under(heavier);
  const Eigen::Vector2d base = there.col(together ? 1 : 0);
  const model::Friction& friction = applied.scenario.friction;
  Eigen::Matrix2d by_mu = there.rightCols(2).colwise() - base;
  by_mu.col(0) /= kStep * friction.nominal;
  by_mu.col(1) /= kStep * friction.reduced;
  if (by_mu.allFinite()) result.bend = bend_of(applied, result.added, by_mu - by_paper.by_mu);
  return result;
}

}  // namespace

std::vector<Eigen::Index> linear_unknowns(const Unknowns& unknowns, bool linear) {
  std::vector<Eigen::Index> found;
  for (Eigen::Index i = 0; i < unknowns.common(); ++i) {
    const FitParameter parameter = unknowns.parameter(i);
    const bool is_linear = i >= unknowns.reported() && parameter != FitParameter::start_phase &&
                           parameter != FitParameter::phase_reference && parameter != FitParameter::scale;
    if (is_linear == linear) found.push_back(i);
  }
  return found;
}

ModelledDisplacement modelled_displacement(const Unknowns& unknowns, const Eigen::VectorXd& values,
                                           const SummaryRun& run, const std::vector<Eigen::Index>& by,
                                           double tolerance) {
  AppliedScenario applied = unknowns.apply_summary(values, run, !by.empty());
  // Each of the model's parameters costs time: those that none of these needs are left out.
  std::vector<model::Parameter> wanted;
  Eigen::MatrixXd chain(0, static_cast<Eigen::Index>(by.size()));
  for (Eigen::Index i = 0; i < applied.chain.rows(); ++i) {
    const Eigen::RowVectorXd row = applied.chain.row(i)(by);
    if (row.isZero(0)) continue;
    wanted.push_back(applied.wanted[static_cast<std::size_t>(i)]);
    chain.conservativeResize(chain.rows() + 1, Eigen::NoChange);
    chain.bottomRows(1) = row;
  }
  const EndPoint end = end_point(applied.scenario, wanted, tolerance, most_steps(unknowns, applied.scenario));
  // Dividing the model keeps the covariance, and with it the minimum, free of the scale.
  ModelledDisplacement result{end.position * applied.stretch / applied.scale, {}};
  if (by.empty()) return result;
  result.jacobian.setZero(2, unknowns.common());
  if (!wanted.empty())
    result.jacobian(Eigen::all, by) = (end.jacobian * chain) * (applied.stretch / applied.scale);
  for (std::size_t i = 0; i < wanted.size(); ++i)
    for (const model::Parameter mu : {model::Parameter::mu1, model::Parameter::mu2})
      if (wanted[i] == mu)
        result.by_mu.col(mu == model::Parameter::mu2) =
            end.jacobian.col(static_cast<Eigen::Index>(i)) * (applied.stretch / applied.scale);
  const auto asked = [&](std::optional<Eigen::Index> i) { return i && std::ranges::count(by, *i) > 0; };
  if (const auto scale = unknowns.find(FitParameter::scale); asked(scale))
    result.jacobian.col(*scale) -= result.position / applied.scale;
  if (const auto w = unknowns.find(FitParameter::angular_frequency);
      asked(w) && run.measured.given_as_velocity)
    result.jacobian.col(*w) += result.position / values(*w);
  return result;
}

std::optional<LinearTerms> LinearTerms::at(const Unknowns& unknowns, const Eigen::VectorXd& values,
                                           double tolerance, int threads) {
  const Problem& problem = unknowns.problem();
  LinearTerms terms;
  terms.linear_ = linear_unknowns(unknowns, true);
  terms.bent_ = linear_unknowns(unknowns, false);
  terms.values_ = values;
  terms.runs_.resize(problem.summary_runs.size());
  std::vector<Eigen::Index> all, laws;
  for (Eigen::Index i = 0; i < unknowns.common(); ++i) {
    all.push_back(i);
    if (std::ranges::count(kLaws, unknowns.parameter(i)) > 0) laws.push_back(i);
  }
  try {
    parallel_for(terms.runs_.size(), threads, [&](std::size_t i) {
      const SummaryRun& data = problem.summary_runs[i];
      Run& run = terms.runs_[i];
      run.here = modelled_displacement(unknowns, values, data, all, tolerance);
      if (laws.empty()) return;
      AddedByLaws there = added_by_laws(unknowns, values, data, run.here, laws);
      run.by_laws = there.added;
      run.bend = std::move(there.bend);
      run.here.jacobian += run.bend;
      run.here.jacobian(Eigen::all, laws) = there.by_laws;
      run.here.position += run.by_laws;
    });
  } catch (const model::InvalidParameter&) {
    return std::nullopt;
  } catch (const model::StepLimitExceeded&) {
    return std::nullopt;
  }
  return terms;
}

Eigen::VectorXd LinearTerms::held(Eigen::VectorXd values) const {
  values(linear_) = values_(linear_);
  return values;
}

void LinearTerms::add(std::size_t index, const Eigen::VectorXd& values,
                      ModelledDisplacement& by_paper) const {
  const Run& run = runs_[index];
  const Eigen::Matrix2Xd columns = run.here.jacobian(Eigen::all, linear_);
  by_paper.position += run.by_laws + columns * (values - values_)(linear_);
  if (run.bend.size() > 0) by_paper.position += run.bend(Eigen::all, bent_) * (values - values_)(bent_);
  if (by_paper.jacobian.size() == 0) return;
  by_paper.jacobian(Eigen::all, linear_) = columns;
  if (run.bend.size() > 0) by_paper.jacobian(Eigen::all, bent_) += run.bend(Eigen::all, bent_);
}

}  // namespace tribotrack::fit::internal
