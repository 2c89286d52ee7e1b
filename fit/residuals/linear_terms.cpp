#include "fit/residuals/linear_terms.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>

#include "fit/residuals/end_point.h"
#include "fit/residuals/free_slide.h"
#include "fit/tools/parameters.h"
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

/// Of a free slide: viscous friction is in its scenario, and it has no gate.
model::RivalLaw law_at(const Unknowns& unknowns, const Eigen::VectorXd& values, bool free_slide) {
  const auto of = [&](FitParameter law) { return unknowns.value_of(law, values); };
  const double fading =
      unknowns.reference_speed() * std::max(of(FitParameter::stribeck_speed), kLeastStribeckSpeed);
  if (free_slide) return {.stribeck = of(FitParameter::stribeck), .fading = fading};
  return {.stribeck = of(FitParameter::stribeck),
          .fading = fading,
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
};

/// A step of one of the model's parameters, small against what makes a motion another.
double step_of(model::Parameter parameter, const model::Scenario& scenario) {
  constexpr double kShare = 1e-5, kAngle = 1e-4;
  const bool sized = parameter == model::Parameter::amplitude || parameter == model::Parameter::amplitude_y ||
                     parameter == model::Parameter::gravity;
  if (sized) return 10 * kShare * std::max(scenario.get(parameter), 1e-9);
  if (parameter == model::Parameter::angular_frequency) return 0.1 * kShare * scenario.get(parameter);
  if (parameter == model::Parameter::velocity_x || parameter == model::Parameter::velocity_y)
    return 10 * kShare * std::max(scenario.initial_velocity.norm(), 1e-9);
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

/// The same by steps of all parameters: `added_in` a scenario, which is `added` in this one.
Eigen::MatrixXd bend_by_steps(const AppliedScenario& applied, const Eigen::VectorXd& added,
                              const Eigen::MatrixX2d& by_mu, const auto& added_in) {
  using model::Parameter;
  Eigen::MatrixXd bend = Eigen::MatrixXd::Zero(added.size(), applied.chain.cols());
  for (std::size_t i = 0; i < applied.wanted.size(); ++i) {
    const Parameter parameter = applied.wanted[i];
    Eigen::VectorXd by;
    if (parameter == Parameter::mu1 || parameter == Parameter::mu2) {
      by = by_mu.col(parameter == Parameter::mu2);
    } else {
      const double step = step_of(parameter, applied.scenario);
      const auto moved_by = [&](double change) -> Eigen::VectorXd {
        model::Scenario near = applied.scenario;
        near.set(parameter, near.get(parameter) + change);
        return added_in(near) - added;
      };
      by = moved_by(step) / step;
      // Laws go by the greater of two amplitudes, which are often equal: there is a kink between.
      if (parameter == Parameter::amplitude || parameter == Parameter::amplitude_y)
        by = 0.5 * (by - moved_by(-step) / step);
    }
    bend += by * applied.chain.row(static_cast<Eigen::Index>(i));
  }
  return bend;
}

/// What the laws at `values` add to a run at `times`; `by_mu`: its derivatives under the paper's law. Where
/// that moves a place by more than `fine`, its derivatives are by all parameters: an integration each.
AddedByLaws added_by_laws(const Unknowns& unknowns, const Eigen::VectorXd& values,
                          const AppliedScenario& applied, const std::vector<double>& times,
                          const Eigen::MatrixX2d& by_mu, const std::vector<Eigen::Index>& laws,
                          double fine = INFINITY, bool free_slide = false) {
  const auto rows = 2 * static_cast<Eigen::Index>(times.size());
  AddedByLaws result{Eigen::VectorXd::Zero(rows),
                     Eigen::MatrixXd::Zero(rows, static_cast<Eigen::Index>(laws.size())),
                     Eigen::MatrixXd::Zero(rows, applied.chain.cols())};
  // Other laws are integrated from rest, or of slides that do not spin.
  if (applied.scenario.start != model::Start::rest || applied.scenario.spin.rate != 0) return result;
  const double unit = applied.stretch / applied.scale;
  // Edges that take a negative time undo what positive ones add, so that chi^2 has no kink at 0.
  const auto edges = unknowns.find(FitParameter::gate_edges);
  const bool undone = edges && values(*edges) < 0;
  Eigen::VectorXd sharp = values, soft = values;
  if (undone) sharp(*edges) = 0, soft(*edges) = -values(*edges);
  const auto law_of = [&](const Eigen::VectorXd& v) { return law_at(unknowns, v, free_slide); };
  const model::RivalLaw as_sharp = law_of(sharp), as_soft = law_of(soft), paper{.fading = as_soft.fading};
  std::vector<model::RivalLaw> beside{paper, as_sharp, as_soft};
  const auto fading = unknowns.find(FitParameter::stribeck_speed);
  for (const Eigen::Index law : laws) {
    if (law == fading) continue;
    Eigen::VectorXd more = law == edges ? soft : sharp;
    more(law) += step_of(unknowns.parameter(law));
    beside.push_back(law_of(more));
  }
  static_assert(3 + kLaws.size() - 1 <= model::kMostRivalLaws);
  constexpr double kStep = 2e-4;  // of mu, and of the speed at which it has fallen
  std::vector<model::RivalLaw> changed(fading ? 4 : 3, as_sharp);
  changed[1].mu1 = changed[2].mu2 = kStep;
  if (fading) changed[3].fading *= 1 + kStep;
  const auto own = static_cast<Eigen::Index>(beside.size()),
             changes = static_cast<Eigen::Index>(changed.size()) - 1;
  const bool together = beside.size() + changed.size() - 1 <= model::kMostRivalLaws;
  if (together) beside.insert(beside.end(), changed.begin() + 1, changed.end());
  const double tolerance = std::isfinite(fine) ? kFineTolerance : kTolerance;
  const auto under = [&](std::span<const model::RivalLaw> all) {
    return Eigen::MatrixXd(unit * model::rival_positions(applied.scenario, times, all, tolerance));
  };
  const Eigen::MatrixXd moved = under(beside);
  const auto by_law = [&](std::size_t k) { return result.by_laws.col(static_cast<Eigen::Index>(k)); };
  Eigen::Index lane = 3;
  for (std::size_t k = 0; k < laws.size(); ++k)
    if (laws[k] != fading)
      by_law(k) =
          (moved.col(lane++) - moved.col(laws[k] == edges ? 2 : 1)) / step_of(unknowns.parameter(laws[k]));
  if (as_soft == paper) return result;
  result.added = 2 * moved.col(1) - moved.col(2) - moved.col(0);

  // Differences of one integration: its errors cancel.
  const Eigen::MatrixXd there = together ? moved : under(changed);
  const Eigen::VectorXd base = there.col(together ? 1 : 0);
  const Eigen::MatrixXd by_change = (there.middleCols(together ? own : 1, changes).colwise() - base) / kStep;
  for (std::size_t k = 0; k < laws.size(); ++k)
    if (laws[k] == fading && values(*fading) > kLeastStribeckSpeed)
      by_law(k) = by_change.col(2) / values(*fading);
  const model::Friction& friction = applied.scenario.friction;
  Eigen::MatrixX2d under_law = by_change.leftCols(2);
  under_law.col(0) /= friction.nominal;
  if (friction.pulse_width > 0) under_law.col(1) /= friction.reduced;
  if (!under_law.allFinite()) return result;
  const auto added_in = [&](const model::Scenario& scenario) -> Eigen::VectorXd {
    const Eigen::MatrixXd all =
        unit * model::rival_positions(scenario, times, std::array{paper, as_sharp, as_soft}, tolerance);
    return 2 * all.col(1) - all.col(2) - all.col(0);
  };
  const bool small = result.added.lpNorm<Eigen::Infinity>() < fine;
  result.bend = small ? bend_of(applied, result.added, under_law - by_mu)
                      : bend_by_steps(applied, result.added, under_law - by_mu, added_in);
  return result;
}

std::vector<Eigen::Index> laws_of(const Unknowns& unknowns) {
  std::vector<Eigen::Index> laws;
  for (Eigen::Index i = 0; i < unknowns.common(); ++i)
    if (std::ranges::count(kLaws, unknowns.parameter(i)) > 0) laws.push_back(i);
  return laws;
}

/// Those that move a run beside its own model.
std::vector<Eigen::Index> laws_of(const Unknowns& unknowns, const TrajectoryRun& run) {
  std::vector<Eigen::Index> laws = laws_of(unknowns);
  if (run.free_slide)
    std::erase_if(laws, [&](Eigen::Index i) {
      return unknowns.parameter(i) != FitParameter::stribeck &&
             unknowns.parameter(i) != FitParameter::stribeck_speed;
    });
  return laws;
}

/// Of the points that are fitted, s from the first.
std::vector<double> times_of(const TrajectoryRun& run) {
  const std::size_t first = run.free_slide ? guess_free_slide(run).first : 0;
  std::vector<double> times;
  for (std::size_t i = first; i < run.track.time.size(); ++i)
    times.push_back(run.track.time[i] - run.track.time[first]);
  return times;
}

}  // namespace

bool has_linear_terms(const Unknowns& unknowns) {
  const Problem& problem = unknowns.problem();
  return (!problem.summary_runs.empty() && !linear_unknowns(unknowns, true).empty()) ||
         std::ranges::any_of(problem.trajectory_runs,
                             [&](const TrajectoryRun& run) { return !laws_of(unknowns, run).empty(); });
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
                                           double tolerance, int threads) {
  const Problem& problem = unknowns.problem();
  LinearTerms terms;
  terms.linear_ = linear_unknowns(unknowns, true);
  terms.bent_ = linear_unknowns(unknowns, false);
  terms.values_ = values;
  const std::vector<Eigen::Index> laws = laws_of(unknowns);
  const std::size_t summaries = problem.summary_runs.size();
  terms.runs_.resize(summaries);
  terms.tracks_.resize(problem.trajectory_runs.size());
  const auto of_displacement = [&](std::size_t i) {
    const SummaryRun& data = problem.summary_runs[i];
    Run& run = terms.runs_[i];
    run.here = modelled_displacement(unknowns, values, data, unknowns.shared(), tolerance);
    if (laws.empty()) return;
    const AppliedScenario applied = unknowns.apply_summary(values, data, unknowns.shared());
    const AddedByLaws there =
        added_by_laws(unknowns, values, applied, {applied.scenario.end_time()}, run.here.by_mu, laws);
    run.by_laws = there.added;
    run.bend = there.bend;
    run.here.jacobian += run.bend;
    run.here.jacobian(Eigen::all, laws) = there.by_laws;
    run.here.position += run.by_laws;
  };
  constexpr double kSeen = 10;
  const auto of_track = [&](std::size_t i) {
    const TrajectoryRun& data = problem.trajectory_runs[i];
    std::vector<Eigen::Index> own = laws_of(unknowns, data);
    if (own.empty()) return;
    AppliedScenario applied = unknowns.apply_trajectory(values, i, true);
    const std::vector<double> times = times_of(data);
    applied.scenario.duration = times.back();
    const Eigen::MatrixX2d by_mu = points_by_mu(applied, times, tolerance);
    const double sd = std::sqrt(0.5 * data.track.covariance.front().trace());
    AddedByLaws there =
        added_by_laws(unknowns, values, applied, times, by_mu, own, kSeen * sd, data.free_slide);
    terms.tracks_[i] = {std::move(own), std::move(there.added), std::move(there.by_laws),
                        std::move(there.bend), unknowns.own(i)};
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

void LinearTerms::add(std::size_t index, const Eigen::VectorXd& values, Eigen::Matrix2Xd& positions,
                      Eigen::MatrixXd& jacobian) const {
  const Track& track = tracks_[index];
  if (track.added.size() == 0) return;
  const Eigen::VectorXd all = values - values_;
  Eigen::VectorXd change(track.bend.cols());
  change << all.head(change.size() - track.own.count), all.segment(track.own.first, track.own.count);
  positions.reshaped() += track.added + track.by_laws * all(track.laws) + track.bend * change;
  if (jacobian.size() == 0) return;
  jacobian += track.bend;
  jacobian(Eigen::all, track.laws) = track.by_laws;
}

}  // namespace tribotrack::fit::internal
