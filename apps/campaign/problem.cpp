#include "apps/campaign/problem.h"

#include <algorithm>

namespace tribotrack::apps {

double reference_mm_per_px(const std::vector<AnalysedRun>& runs) {
  double sum = 0;
  int count = 0;
  for (const AnalysedRun& run : runs)
    if (run.failure.empty() && run.track && run.track->mm_per_px) {
      sum += *run.track->mm_per_px;
      ++count;
    }
  return count > 0 ? sum / count : 1;
}

fit::Problem problem_of(const Campaign& campaign, const std::vector<AnalysedRun>& runs) {
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

  double scale_sd = 0, phase_sd = 0, amplitude_sd = 0;
  double amplitude = 0;  // of the first driven run
  int scaled = 0, driven = 0;
  for (const AnalysedRun& run : runs) {
    if (!run.failure.empty()) continue;
    const std::string& name = run.run->name;
    if (run.track && run.track->mm_per_px && *run.track->mm_per_px > 0) {
      scale_sd += run.track->mm_per_px_sd.value_or(0) / *run.track->mm_per_px;
      ++scaled;
    }
    if (!run.run->free_slide) {
      if (driven++ == 0) amplitude = std::max(run.scenario.drive.amplitude, run.scenario.drive.amplitude_y);
      if (run.measurement && run.measurement->coded) {
        phase_sd += run.measurement->coded->delay_sd;
        if (run.amplitude_from_track) amplitude_sd += run.measurement->coded->attenuation_sd;
      }
    }
    if (run.run->free_slide)
      problem.trajectory_runs.push_back({name, run.scenario, run.track->table, true, false});
    else if (campaign.fit.trajectory && run.track) {
      problem.trajectory_runs.push_back(
          {name, run.scenario, run.track->table, false, run.amplitude_from_track});
      if (run.measurement && run.measurement->platform &&
          (run.measurement->phase_source == "marker" || run.measurement->phase_source == "texture"))
        problem.trajectory_runs.back().start_phase_sd = run.measurement->platform->phase_at_zero.sd;
    } else
      problem.summary_runs.push_back({name, run.scenario, run.displacement, run.amplitude_from_track});
  }
  // Runs that share one scale share its sd; where they do not, most of it is common (the part's true
  // diameter).
  const auto know = [&](fit::FitParameter quantity, double sd, const char* from) {
    if (sd > 0) problem.conditions.push_back({quantity, sd, from});
  };
  know(fit::FitParameter::scale, scaled > 0 ? scale_sd / scaled : 0, "part's diameter");
  // A coder errs alike in all of them: what is common moves the parameters by the mean over the runs.
  if (driven > 0) {
    know(fit::FitParameter::phase_reference, phase_sd / driven, fit::kFromCoder);
    know(fit::FitParameter::amplitude, amplitude_sd / driven * amplitude, fit::kFromCoder);
  }
  return problem;
}

}  // namespace tribotrack::apps
