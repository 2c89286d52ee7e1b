#include "fit/residuals/linear_terms.h"

#include <algorithm>
#include <cmath>

#include "fit/residuals/end_point.h"
#include "model/parallel.h"
#include "model/rival_laws.h"
#include "model/trajectory.h"

namespace tribotrack::fit::internal {
namespace {

/// Differences of two motions: of the path.
constexpr double kTolerance = 1e-6;

/// A step far above the integration's error over which a displacement is still linear.
double step_of(FitParameter law) {
  switch (law) {
    case FitParameter::viscous:
      return 0.01;
    case FitParameter::gate_edges:
      return 0.001;
    default:
      return 0.002;
  }
}

model::RivalLaw law_at(const Unknowns& unknowns, const Eigen::VectorXd& values) {
  const auto of = [&](FitParameter law) {
    const auto i = unknowns.find(law);
    return i ? values(*i) : 0;
  };
  return {.stribeck = of(FitParameter::stribeck),
          .viscous = of(FitParameter::viscous),
          .rise = std::sqrt(std::max(0.0, of(FitParameter::gate_edges))) / unknowns.reference_frequency(),
          .mu2_speed = of(FitParameter::mu2_speed),
          .static_friction = of(FitParameter::static_friction)};
}

/// What the laws at `values` add to a run's displacement, and the derivatives by those that are unknown.
void add_laws(const Unknowns& unknowns, const Eigen::VectorXd& values, const SummaryRun& run,
              Eigen::Vector2d& by_laws, Eigen::Matrix2Xd& columns) {
  const AppliedScenario applied = unknowns.apply_summary(values, run, false);
  if (applied.scenario.start != model::Start::rest) return;  // other laws are integrated from rest
  const auto moved = [&](const model::RivalLaw& law) -> Eigen::Vector2d {
    return model::rival_displacement(applied.scenario, law, kTolerance) * applied.stretch / applied.scale;
  };
  const Eigen::Vector2d without = moved({}), with = moved(law_at(unknowns, values));
  by_laws = with - without;
  for (const FitParameter law : kLaws) {
    const auto i = unknowns.find(law);
    if (!i) continue;
    Eigen::VectorXd beside = values;
    if (law == FitParameter::gate_edges) beside(*i) = std::max(0.0, beside(*i));
    beside(*i) += step_of(law);
    columns.col(*i) = (moved(law_at(unknowns, beside)) - with) / step_of(law);
  }
}

bool any_law(const Unknowns& unknowns) {
  return std::ranges::any_of(kLaws, [&](FitParameter law) { return unknowns.find(law).has_value(); });
}

}  // namespace

bool is_linear(const Unknowns& unknowns, Eigen::Index unknown) {
  const FitParameter parameter = unknowns.parameter(unknown);
  return unknown >= unknowns.reported() && parameter != FitParameter::start_phase &&
         parameter != FitParameter::phase_reference && parameter != FitParameter::scale;
}

std::vector<Eigen::Index> linear_unknowns(const Unknowns& unknowns, bool linear) {
  std::vector<Eigen::Index> found;
  for (Eigen::Index i = 0; i < unknowns.common(); ++i)
    if (is_linear(unknowns, i) == linear) found.push_back(i);
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
  const EndPoint end = end_point(applied.scenario, wanted, tolerance);
  // Dividing the model keeps the covariance, and with it the minimum, free of the scale.
  ModelledDisplacement result{end.position * applied.stretch / applied.scale, {}};
  if (by.empty()) return result;
  result.jacobian.setZero(2, unknowns.common());
  if (!wanted.empty())
    result.jacobian(Eigen::all, by) = (end.jacobian * chain) * (applied.stretch / applied.scale);
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
  terms.at_ = values(terms.linear_);
  terms.runs_.resize(problem.summary_runs.size());
  const bool laws = any_law(unknowns);
  try {
    parallel_for(terms.runs_.size(), threads, [&](std::size_t i) {
      const SummaryRun& data = problem.summary_runs[i];
      Run& run = terms.runs_[i];
      Eigen::Matrix2Xd all = modelled_displacement(unknowns, values, data, terms.linear_, tolerance).jacobian;
      if (laws) add_laws(unknowns, values, data, run.by_laws, all);
      run.columns = all(Eigen::all, terms.linear_);
    });
  } catch (const model::InvalidParameter&) {
    return std::nullopt;
  } catch (const model::StepLimitExceeded&) {
    return std::nullopt;
  }
  return terms;
}

Eigen::VectorXd LinearTerms::held(Eigen::VectorXd values) const {
  values(linear_) = at_;
  return values;
}

Eigen::Vector2d LinearTerms::added(std::size_t index, const Eigen::VectorXd& values) const {
  const Run& run = runs_[index];
  return run.by_laws + run.columns * (values(linear_) - at_);
}

void LinearTerms::put_derivatives(std::size_t index, Eigen::Ref<Eigen::Matrix2Xd> by_unknowns) const {
  by_unknowns(Eigen::all, linear_) = runs_[index].columns;
}

}  // namespace tribotrack::fit::internal
