#include "fit/residuals/linear_terms.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>

#include "fit/residuals/end_point.h"
#include "model/parallel.h"
#include "model/rival_laws.h"
#include "model/trajectory.h"

namespace tribotrack::fit::internal {
namespace {

/// Of motions that are subtracted from each other: their errors cancel for the most part. Points of tracks,
/// and derivatives by all parameters, ask for more.
constexpr double kTolerance = 1.5e-5, kFineTolerance = 1e-6;

/// A step far above the integration's error over which a displacement is still linear: near the threshold of
/// sliding that is not far.
double step_of(FitParameter law) {
  return law == FitParameter::viscous ? 1e-3 : law == FitParameter::gate_edges ? 1e-4 : 2e-4;
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

/// Derivatives of a track's places by mu1 and mu2 under the paper's law.
Eigen::MatrixX2d points_by_mu(const AppliedScenario& applied, const std::vector<double>& times,
                              double tolerance) {
  Eigen::Matrix2Xd positions;
  Eigen::MatrixXd by_mu;
  model::IntegrationOptions options;
  options.tolerance = tolerance;
  options.derivatives = {model::Parameter::mu1, model::Parameter::mu2};
  model::integrate(applied.scenario, options).positions_at(times, 0, positions, &by_mu);
  return by_mu / applied.scale;
}

/// What laws add to a run's places, x and y of each below each other, and its derivatives.
struct AddedByLaws {
  Eigen::VectorXd added;
  Eigen::MatrixXd by_laws;  ///< by the laws among the unknowns
  Eigen::MatrixXd bend;     ///< by the others
  bool borrowed = false;    ///< the latter is that of an earlier step
};

/// What laws add here by the derivatives of an earlier step.
struct Foretold {
  const Eigen::VectorXd& before;  ///< what they added there
  Eigen::VectorXd added;
  const Eigen::MatrixXd& bend;  ///< there
};

/// A step of one of the model's parameters, small against what makes a motion another.
double step_of(model::Parameter parameter, const model::Scenario& scenario) {
  constexpr double kShare = 1e-5, kAngle = 1e-4;
  const bool sized = parameter == model::Parameter::amplitude || parameter == model::Parameter::amplitude_y ||
                     parameter == model::Parameter::gravity;
  if (sized) return 10 * kShare * std::max(scenario.get(parameter), 1e-9);
  if (parameter == model::Parameter::angular_frequency) return 0.1 * kShare * scenario.get(parameter);
  const bool tilt = parameter == model::Parameter::tilt_x || parameter == model::Parameter::tilt_y;
  return tilt ? kShare : kAngle;
}

/// The derivatives of what laws add, with the chain from the run's friction to the unknowns.
Eigen::MatrixXd bend_of(const AppliedScenario& applied, const Eigen::VectorXd& added,
                        const Eigen::MatrixX2d& by_mu) {
  Eigen::MatrixXd bend = Eigen::MatrixXd::Zero(added.size(), applied.chain.cols());
  const model::Drive& drive = applied.scenario.drive;
  // epsilon = +pi/2 circles clockwise: a later pulse turns the drift by -lag. Along a line it does not.
  const double turning = -std::sin(drive.phase_shift) * std::min(drive.amplitude, drive.amplitude_y) /
                         std::max({drive.amplitude, drive.amplitude_y, 1e-300});
  Eigen::Matrix2Xd turned = added.reshaped(2, added.size() / 2).colwise().reverse();
  turned.row(0) *= -turning;
  turned.row(1) *= turning;
  for (std::size_t i = 0; i < applied.wanted.size(); ++i) {
    const Eigen::RowVectorXd chain = applied.chain.row(static_cast<Eigen::Index>(i));
    if (applied.wanted[i] == model::Parameter::mu1) bend += by_mu.col(0) * chain;
    if (applied.wanted[i] == model::Parameter::mu2) bend += by_mu.col(1) * chain;
    if (applied.wanted[i] == model::Parameter::lag) bend += turned.reshaped() * chain;
  }
  return bend;
}

/// What the laws at `values` add to a run at `times`; `by_mu`: its derivatives under the paper's law. Where
/// that moves a place by more than `fine`, its derivatives are by all parameters: an integration each, unless
/// those are taken that have foretold it to a tenth of its change or a hundredth of `fine`.
AddedByLaws added_by_laws(const Unknowns& unknowns, const Eigen::VectorXd& values,
                          const AppliedScenario& applied, const std::vector<double>& times,
                          const Eigen::MatrixX2d& by_mu, const std::vector<Eigen::Index>& laws,
                          double fine = INFINITY, const std::optional<Foretold>& foretold = std::nullopt) {
  const auto rows = 2 * static_cast<Eigen::Index>(times.size());
  AddedByLaws result{Eigen::VectorXd::Zero(rows),
                     Eigen::MatrixXd::Zero(rows, static_cast<Eigen::Index>(laws.size())),
                     Eigen::MatrixXd::Zero(rows, applied.chain.cols())};
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
  constexpr double kStep = 2e-4;  // of mu
  std::array<model::RivalLaw, 3> heavier{as_sharp, as_sharp, as_sharp};
  heavier[1].mu1 = heavier[2].mu2 = kStep;
  const bool together = beside.size() + 2 <= model::kMostRivalLaws;
  if (together) beside.insert(beside.end(), heavier.begin() + 1, heavier.end());
  static_assert(3 + kLaws.size() <= model::kMostRivalLaws);
  const double tolerance = std::isfinite(fine) ? kFineTolerance : kTolerance;
  const auto under = [&](std::span<const model::RivalLaw> all) {
    return Eigen::MatrixXd(unit * model::rival_positions(applied.scenario, times, all, tolerance));
  };
  const Eigen::MatrixXd moved = under(beside);
  for (std::size_t k = 0; k < laws.size(); ++k)
    result.by_laws.col(static_cast<Eigen::Index>(k)) =
        (moved.col(static_cast<Eigen::Index>(3 + k)) - moved.col(laws[k] == edges ? 2 : 1)) /
        step_of(unknowns.parameter(laws[k]));
  if (as_soft == paper) return result;
  result.added = 2 * moved.col(1) - moved.col(2) - moved.col(0);

  // Differences of one integration: its errors cancel.
  const Eigen::MatrixXd there = together ? moved : under(heavier);
  const Eigen::VectorXd base = there.col(together ? 1 : 0);
  const model::Friction& friction = applied.scenario.friction;
  Eigen::MatrixX2d under_law = there.rightCols(2).colwise() - base;
  under_law.col(0) /= kStep * friction.nominal;
  under_law.col(1) /= kStep * friction.reduced;
  if (!under_law.allFinite()) return result;
  if (result.added.lpNorm<Eigen::Infinity>() < fine) {
    result.bend = bend_of(applied, result.added, under_law - by_mu);
    return result;
  }
  constexpr double kShare = 0.1, kUnseen = 0.01;
  const auto size = [](const Eigen::VectorXd& v) { return v.lpNorm<Eigen::Infinity>(); };
  if (foretold && size(foretold->added - result.added) <
                      std::max(kShare * size(result.added - foretold->before), kUnseen * fine)) {
    result.bend = foretold->bend;
    result.borrowed = true;
    return result;
  }
  const std::array three{paper, as_sharp, as_soft};
  for (std::size_t i = 0; i < applied.wanted.size(); ++i) {
    const model::Parameter parameter = applied.wanted[i];
    Eigen::VectorXd by;
    if (parameter == model::Parameter::mu1 || parameter == model::Parameter::mu2) {
      by = (under_law - by_mu).col(parameter == model::Parameter::mu2);
    } else {
      const double step = step_of(parameter, applied.scenario);
      const auto moved_by = [&](double change) -> Eigen::VectorXd {
        model::Scenario near = applied.scenario;
        near.set(parameter, near.get(parameter) + change);
        const Eigen::MatrixXd all = unit * model::rival_positions(near, times, three, tolerance);
        return 2 * all.col(1) - all.col(2) - all.col(0) - result.added;
      };
      by = moved_by(step) / step;
      // Laws go by the greater of two amplitudes, which are often equal: there is a kink between.
      if (parameter == model::Parameter::amplitude || parameter == model::Parameter::amplitude_y)
        by = 0.5 * (by - moved_by(-step) / step);
    }
    result.bend += by * applied.chain.row(static_cast<Eigen::Index>(i));
  }
  return result;
}

std::vector<Eigen::Index> laws_of(const Unknowns& unknowns) {
  std::vector<Eigen::Index> laws;
  for (Eigen::Index i = 0; i < unknowns.common(); ++i)
    if (std::ranges::count(kLaws, unknowns.parameter(i)) > 0) laws.push_back(i);
  return laws;
}

}  // namespace

bool has_linear_terms(const Unknowns& unknowns) {
  const Problem& problem = unknowns.problem();
  return (!problem.summary_runs.empty() && !linear_unknowns(unknowns, true).empty()) ||
         (problem.has_driven_tracks() && !laws_of(unknowns).empty());
}

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
  const AppliedScenario applied = unknowns.apply_summary(values, run, by);
  const std::vector<model::Parameter>& wanted = applied.wanted;
  const EndPoint end = end_point(applied.scenario, wanted, tolerance, unknowns.most_steps(applied.scenario));
  // Dividing the model keeps the covariance, and with it the minimum, free of the scale.
  ModelledDisplacement result{end.position * applied.stretch / applied.scale, {}};
  if (by.empty()) return result;
  result.jacobian.setZero(2, unknowns.common());
  if (!wanted.empty()) result.jacobian = (end.jacobian * applied.chain) * (applied.stretch / applied.scale);
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
                                           double tolerance, int threads, const LinearTerms* before) {
  const Problem& problem = unknowns.problem();
  LinearTerms terms;
  terms.linear_ = linear_unknowns(unknowns, true);
  terms.bent_ = linear_unknowns(unknowns, false);
  terms.values_ = values;
  terms.laws_ = laws_of(unknowns);
  const std::size_t summaries = problem.summary_runs.size();
  terms.runs_.resize(summaries);
  terms.tracks_.resize(problem.trajectory_runs.size());
  const auto of_displacement = [&](std::size_t i) {
    const SummaryRun& data = problem.summary_runs[i];
    Run& run = terms.runs_[i];
    run.here = modelled_displacement(unknowns, values, data, unknowns.shared(), tolerance);
    if (terms.laws_.empty()) return;
    const AppliedScenario applied = unknowns.apply_summary(values, data, unknowns.shared());
    const AddedByLaws there =
        added_by_laws(unknowns, values, applied, {applied.scenario.end_time()}, run.here.by_mu, terms.laws_);
    run.by_laws = there.added;
    run.bend = there.bend;
    run.here.jacobian += run.bend;
    run.here.jacobian(Eigen::all, terms.laws_) = there.by_laws;
    run.here.position += run.by_laws;
  };
  constexpr double kSeen = 10;
  const auto of_track = [&](std::size_t i) {
    const TrajectoryRun& data = problem.trajectory_runs[i];
    if (data.free_slide || terms.laws_.empty()) return;
    AppliedScenario applied = unknowns.apply_trajectory(values, i, true);
    std::vector<double> times = data.track.time;
    for (double& time : times) time -= data.track.time.front();
    applied.scenario.duration = times.back();
    const Eigen::MatrixX2d by_mu = points_by_mu(applied, times, tolerance);
    const double sd = std::sqrt(0.5 * data.track.covariance.front().trace());
    std::optional<Foretold> foretold;
    if (before && before->tracks_[i].added.size() > 0)
      foretold.emplace(before->tracks_[i].added, before->added(i, values), before->tracks_[i].bend);
    AddedByLaws there =
        added_by_laws(unknowns, values, applied, times, by_mu, terms.laws_, kSeen * sd, foretold);
    terms.tracks_[i] = {std::move(there.added), std::move(there.by_laws), std::move(there.bend),
                        unknowns.own(i), there.borrowed};
  };
  try {
    parallel_for(summaries + terms.tracks_.size(), threads,
                 [&](std::size_t i) { i < summaries ? of_displacement(i) : of_track(i - summaries); });
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

Eigen::VectorXd LinearTerms::added(std::size_t index, const Eigen::VectorXd& values) const {
  const Track& track = tracks_[index];
  const Eigen::VectorXd all = values - values_;
  Eigen::VectorXd change(track.bend.cols());
  change << all.head(change.size() - track.own.count), all.segment(track.own.first, track.own.count);
  return track.added + track.by_laws * all(laws_) + track.bend * change;
}

bool LinearTerms::borrowed() const {
  return std::ranges::any_of(tracks_, &Track::borrowed);
}

void LinearTerms::add(std::size_t index, const Eigen::VectorXd& values, Eigen::Matrix2Xd& positions,
                      Eigen::MatrixXd& jacobian) const {
  const Track& track = tracks_[index];
  if (track.added.size() == 0) return;
  positions.reshaped() += added(index, values);
  if (jacobian.size() == 0) return;
  jacobian += track.bend;
  jacobian(Eigen::all, laws_) = track.by_laws;
}

}  // namespace tribotrack::fit::internal
