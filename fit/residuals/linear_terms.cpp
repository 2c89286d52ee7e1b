#include "fit/residuals/linear_terms.h"

#include <algorithm>
#include <cmath>
#include <numbers>

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

/// What the laws at `values` add to a run's displacement, and the derivatives by those that are unknown.
void add_laws(const Unknowns& unknowns, const Eigen::VectorXd& values, const SummaryRun& run,
              Eigen::Vector2d& by_laws, Eigen::Matrix2Xd& columns) {
  const AppliedScenario applied = unknowns.apply_summary(values, run, false);
  if (applied.scenario.start != model::Start::rest) return;  // other laws are integrated from rest
  // Edges that take a negative time undo what positive ones add, so that chi^2 has no kink at 0.
  const auto edges = unknowns.find(FitParameter::gate_edges);
  const bool undone = edges && values(*edges) < 0;
  Eigen::VectorXd sharp = values, soft = values;
  if (undone) sharp(*edges) = 0, soft(*edges) = -values(*edges);
  static_assert(3 + kLaws.size() <= model::kMostRivalLaws);
  std::vector<Eigen::Index> by;
  std::vector<model::RivalLaw> laws{{}, law_at(unknowns, sharp), law_at(unknowns, soft)};
  for (const FitParameter law : kLaws) {
    const auto i = unknowns.find(law);
    if (!i) continue;
    Eigen::VectorXd beside = i == edges ? soft : sharp;
    beside(*i) += step_of(law);
    by.push_back(*i);
    laws.push_back(law_at(unknowns, beside));
  }
  const Eigen::Matrix2Xd moved =
      model::rival_displacements(applied.scenario, laws, kTolerance) * (applied.stretch / applied.scale);
  const Eigen::Vector2d paper = moved.col(0), without_edges = moved.col(1), with = moved.col(2);
  if (laws[2] != laws[0]) by_laws = 2 * without_edges - with - paper;
  for (std::size_t k = 0; k < by.size(); ++k)
    columns.col(by[k]) =
        (moved.col(3 + k) - (by[k] == edges ? with : without_edges)) / step_of(unknowns.parameter(by[k]));
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
  const auto asked = [&](std::optional<Eigen::Index> i) { return i && std::ranges::count(by, *i) > 0; };
  if (const auto scale = unknowns.find(FitParameter::scale); asked(scale))
    result.jacobian.col(*scale) -= result.position / applied.scale;
  if (const auto w = unknowns.find(FitParameter::angular_frequency);
      asked(w) && run.measured.given_as_velocity)
    result.jacobian.col(*w) += result.position / values(*w);
  return result;
}

std::optional<LinearTerms> LinearTerms::at(const Unknowns& unknowns, const Eigen::VectorXd& values,
                                           double tolerance, int threads, const LinearTerms* laws_of) {
  const Problem& problem = unknowns.problem();
  LinearTerms terms;
  terms.linear_ = linear_unknowns(unknowns, true);
  terms.values_ = values;
  terms.runs_.resize(problem.summary_runs.size());
  std::vector<Eigen::Index> all, laws;
  for (Eigen::Index i = 0; i < unknowns.common(); ++i) {
    all.push_back(i);
    if (std::ranges::count(kLaws, unknowns.parameter(i)) > 0) laws.push_back(i);
  }
  terms.laws_are_new_ = laws.empty() || laws_of == nullptr;
  try {
    parallel_for(terms.runs_.size(), threads, [&](std::size_t i) {
      const SummaryRun& data = problem.summary_runs[i];
      Run& run = terms.runs_[i];
      run.here = modelled_displacement(unknowns, values, data, all, tolerance);
      if (!terms.laws_are_new_) {
        const Run& known = laws_of->runs_[i];
        const Eigen::Matrix2Xd columns = known.here.jacobian(Eigen::all, laws);
        run.here.jacobian(Eigen::all, laws) = columns;
        run.by_laws = known.by_laws + columns * (values - laws_of->values_)(laws);
      } else if (!laws.empty()) {
        add_laws(unknowns, values, data, run.by_laws, run.here.jacobian);
      }
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
  if (by_paper.jacobian.size() > 0) by_paper.jacobian(Eigen::all, linear_) = columns;
}

}  // namespace tribotrack::fit::internal
