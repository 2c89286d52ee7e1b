#include "apps/campaign/problem.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "apps/campaign/own_errors.h"

namespace tribotrack::apps {

double reference_mm_per_px(const std::vector<AnalysedRun>& runs) {
  double sum = 0;
  int count = 0;
  for (const AnalysedRun& run : runs)
    if (run.takes_part() && run.track && run.track->mm_per_px) {
      sum += *run.track->mm_per_px;
      ++count;
    }
  return count > 0 ? sum / count : 1;
}

namespace {

using fit::FitParameter;

void add_run(const Campaign& campaign, const AnalysedRun& run, fit::Problem& problem) {
  const std::string& name = run.run->name;
  if (run.run->free_slide) {
    fit::TrajectoryRun slide{name, run.scenario, run.track->table, true, false};
    slide.slope = run.run->slope.value_or(0);
    problem.trajectory_runs.push_back(std::move(slide));
  } else if (campaign.fit.trajectory && run.track) {
    fit::TrajectoryRun trajectory{name, run.scenario, run.track->table, false, run.amplitude_from_track};
    trajectory.start_phase_sd = sd_of(run.own, model::Parameter::start_phase);
    trajectory.own = without(run.own, {model::Parameter::start_phase});
    problem.trajectory_runs.push_back(std::move(trajectory));
  } else {
    problem.summary_runs.push_back({name, run.scenario, run.displacement, run.amplitude_from_track, run.own});
  }
}

/// The drive whose amplitude and frequency a fit names: that of its first driven run.
model::Drive reference_drive(const fit::Problem& problem) {
  for (const auto& run : problem.summary_runs)
    if (run.scenario.drive.amplitude > 0 || run.scenario.drive.amplitude_y > 0) return run.scenario.drive;
  for (const auto& run : problem.trajectory_runs)
    if (run.scenario.drive.amplitude > 0 || run.scenario.drive.amplitude_y > 0) return run.scenario.drive;
  if (!problem.summary_runs.empty()) return problem.summary_runs.front().scenario.drive;
  return problem.trajectory_runs.empty() ? model::Drive{} : problem.trajectory_runs.front().scenario.drive;
}

/// What a relative error is relative to, or 1.
double size_of(FitParameter quantity, const model::Drive& drive) {
  switch (quantity) {
    case FitParameter::amplitude:
      return std::max(drive.amplitude, drive.amplitude_y);
    case FitParameter::angular_frequency:
      return drive.angular_frequency;
    case FitParameter::gravity:
      return drive.gravity;
    default:
      return 1;
  }
}

/// The value that the runs have, as a fit counts it.
double value_of(FitParameter quantity, const model::Drive& drive) {
  switch (quantity) {
    case FitParameter::tilt_x:
      return drive.tilt_x;
    case FitParameter::tilt_y:
      return drive.tilt_y;
    default:
      return size_of(quantity, drive);
  }
}

/// Each shared error is a condition, or the prior of what is fitted.
void add_conditions(const SharedConditions& shared, fit::Problem& problem) {
  const model::Drive drive = reference_drive(problem);
  std::map<FitParameter, double> variance;
  for (const SharedError& error : shared.errors) {
    const double sd = error.sd * size_of(error.quantity, drive);
    if (std::count(problem.free.begin(), problem.free.end(), error.quantity) == 0)
      problem.conditions.push_back({error.quantity, sd, error.from});
    else if (error.known_beforehand)
      variance[error.quantity] += sd * sd;
  }
  for (const auto& [quantity, sum] : variance)
    problem.prior.try_emplace(quantity, fit::Prior{value_of(quantity, drive), std::sqrt(sum)});
}

}  // namespace

fit::Problem problem_of(const Campaign& campaign, const std::vector<AnalysedRun>& runs,
                        const SharedConditions& shared) {
  fit::Problem problem;
  problem.free = campaign.fit.parameters;
  const double mm_per_px = reference_mm_per_px(runs);
  const auto si = [&](fit::FitParameter parameter, double value) {
    return parameter == fit::FitParameter::scale ? value / mm_per_px
                                                 : value * si_per_campaign_unit(parameter);
  };
  for (const auto& [parameter, value] : campaign.fit.fixed) problem.fixed[parameter] = si(parameter, value);
  for (const auto& [parameter, value] : campaign.fit.guess) problem.start[parameter] = si(parameter, value);
  for (const auto& [parameter, prior] : campaign.fit.prior)
    problem.prior[parameter] = {si(parameter, prior.mean), si(parameter, prior.sd)};

  for (const AnalysedRun& run : runs)
    if (run.takes_part()) add_run(campaign, run, problem);
  add_conditions(shared, problem);
  for (const std::string& key : shared.taken_as_exact)
    if (key == "diameter_mm" || key == "mm_per_px" || key == "tag_mm")
      problem.exact.emplace_back(fit::FitParameter::scale, key);
  return problem;
}

}  // namespace tribotrack::apps
