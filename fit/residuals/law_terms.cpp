#include "fit/residuals/law_terms.h"

#include <algorithm>
#include <cmath>

#include "fit/residuals/point_model.h"
#include "model/parallel.h"
#include "model/rival_laws.h"
#include "model/trajectory.h"

namespace tribotrack::fit::internal {
namespace {

/// Differences of two motions: of the path.
constexpr double kTolerance = 1e-7;

/// A step far above the integration's error over which a displacement is still linear.
double step_of(FitParameter law) {
  switch (law) {
    case FitParameter::stribeck_speed:
      return 0.1;
    case FitParameter::viscous:
      return 0.1;
    case FitParameter::gate_edges:
      return 0.01;
    default:
      return 0.02;
  }
}

model::RivalLaw law_at(const Unknowns& unknowns, const Eigen::VectorXd& values) {
  const auto of = [&](FitParameter law) {
    const auto i = unknowns.find(law);
    return i ? values(*i) : 0;
  };
  return {.stribeck = of(FitParameter::stribeck),
          .fading_speed = std::exp(of(FitParameter::stribeck_speed)),
          .viscous = of(FitParameter::viscous),
          .rise = std::sqrt(std::max(0.0, of(FitParameter::gate_edges))) / unknowns.reference_frequency(),
          .mu2_speed = of(FitParameter::mu2_speed),
          .static_friction = of(FitParameter::static_friction)};
}

/// Other laws are integrated from rest, or an initial velocity without spin.
bool can_be_integrated(const model::Scenario& scenario) {
  return scenario.start == model::Start::rest && scenario.spin.rate == 0;
}

}  // namespace

std::vector<Eigen::Index> unknown_laws(const Unknowns& unknowns) {
  std::vector<Eigen::Index> found;
  for (const FitParameter law : kLaws)
    if (const auto i = unknowns.find(law)) found.push_back(*i);
  return found;
}

std::optional<LawTerms> LawTerms::at(const Unknowns& unknowns, const Eigen::VectorXd& values,
                                     const std::vector<const std::vector<double>*>& times, int threads) {
  const Problem& problem = unknowns.problem();
  LawTerms terms;
  terms.unknowns_ = unknown_laws(unknowns);
  terms.at_ = values;
  terms.runs_.resize(problem.summary_runs.size() + problem.trajectory_runs.size());
  const model::RivalLaw here = law_at(unknowns, values);
  std::vector<model::RivalLaw> beside;
  std::vector<double> steps;
  for (const Eigen::Index i : terms.unknowns_) {
    Eigen::VectorXd moved = values;
    steps.push_back(step_of(unknowns.parameter(i)));
    if (unknowns.parameter(i) == FitParameter::gate_edges) moved(i) = std::max(0.0, moved(i));
    moved(i) += steps.back();
    beside.push_back(law_at(unknowns, moved));
  }
  try {
    parallel_for(terms.runs_.size(), threads, [&](std::size_t i) {
      const bool summary = i < problem.summary_runs.size();
      const std::size_t track = i - problem.summary_runs.size();
      const AppliedScenario applied = summary ? unknowns.apply_summary(values, problem.summary_runs[i], false)
                                              : unknowns.apply_trajectory(values, track, false);
      if (!can_be_integrated(applied.scenario)) return;
      const auto moved = [&](const model::RivalLaw& law) -> Eigen::Matrix2Xd {
        if (summary)
          return model::rival_displacement(applied.scenario, law, kTolerance) * applied.stretch /
                 applied.scale;
        model::Scenario scenario = applied.scenario;
        scenario.duration = times[track]->back();
        return model::rival_positions(scenario, law, *times[track], kTolerance) / applied.scale;
      };
      const Eigen::Matrix2Xd without = moved({}), with = moved(here);
      Run& run = terms.runs_[i];
      run.there = with - without;
      for (std::size_t k = 0; k < beside.size(); ++k)
        run.columns.push_back((moved(beside[k]) - with) / steps[k]);
    });
  } catch (const model::InvalidParameter&) {
    return std::nullopt;
  }
  return terms;
}

Eigen::Matrix2Xd LawTerms::added(std::size_t index, const Eigen::VectorXd& values) const {
  const Run& run = runs_[index];
  Eigen::Matrix2Xd sum = run.there;
  for (std::size_t k = 0; k < run.columns.size(); ++k)
    sum += (values(unknowns_[k]) - at_(unknowns_[k])) * run.columns[k];
  return sum;
}

void LawTerms::add_derivatives(std::size_t index, Eigen::Ref<Eigen::MatrixXd> columns) const {
  const Run& run = runs_[index];
  for (std::size_t k = 0; k < run.columns.size(); ++k) columns.col(unknowns_[k]) += run.columns[k].reshaped();
}

}  // namespace tribotrack::fit::internal
