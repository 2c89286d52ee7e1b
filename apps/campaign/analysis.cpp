#include "apps/campaign/analysis.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <numbers>

#include "apps/files/scope_file.h"
#include "apps/program/errors.h"
#include "fit/gate_timing.h"

namespace tribotrack::apps {

namespace {

/// Conditions of a run: what is given beats what was measured.
model::Drive drive_of(const Campaign& campaign, const CampaignRun& run, const RunMeasurement* measured,
                      bool& amplitude_from_track) {
  const PlatformSection& given = campaign.platform;
  model::Drive drive;
  drive.gravity = given.gravity;
  drive.tilt_x = given.tilt_x;
  drive.tilt_y = given.tilt_y;
  if (run.free_slide) {
    drive.amplitude = drive.amplitude_y = 0;
    return drive;
  }
  const fit::PlatformMotion* seen =
      measured != nullptr && measured->platform ? &*measured->platform : nullptr;
  const auto demand = [&](const char* key) {
    return InvalidInput(
        fmt::format("{}: run \"{}\": {} is neither given nor seen; give it in [platform] (or the run), or "
                    "`marker_px` in [camera]",
                    run.place, run.name, key));
  };
  const std::optional<double> amplitude = run.amplitude ? run.amplitude : given.amplitude;
  if (amplitude) {
    drive.amplitude = *amplitude;
    drive.amplitude_y = given.amplitude_y.value_or(*amplitude);
  } else if (seen != nullptr) {
    drive.amplitude = seen->amplitude.value;
    drive.amplitude_y = given.amplitude_y.value_or(seen->amplitude_y.value);
    amplitude_from_track = true;
  } else {
    throw demand("amplitude_mm");
  }
  const std::optional<double> frequency =
      run.angular_frequency ? run.angular_frequency : given.angular_frequency;
  if (!frequency && seen == nullptr) throw demand("angular_frequency_rad_s");
  drive.angular_frequency = frequency ? *frequency : seen->angular_frequency.value;
  if (given.phase_shift)
    drive.phase_shift = *given.phase_shift;
  else if (seen != nullptr)
    drive.phase_shift = seen->phase_shift.value;
  return drive;
}

}  // namespace

namespace {

/// The run's trace with its events. Throws InvalidInput naming the file.
ScopeEvidence scope_of(const Campaign& campaign, const CampaignRun& run, const TrackFile& track) {
  const ScopeSection& section = campaign.scope;
  const ScopeFile file = read_scope_file(*run.scope);
  const auto channel = [&](int number, const char* key) {
    if (number == 0) return std::vector<double>();
    if (static_cast<std::size_t>(number) > file.channels.size())
      throw InvalidInput(fmt::format("{}:1: holds {} channel{}, but [scope] {} = {}", run.scope->string(),
                                     file.channels.size(), file.channels.size() == 1 ? "" : "s", key,
                                     number));
    return file.channels[static_cast<std::size_t>(number) - 1];
  };
  fit::ScopeTrace trace{file.start_s, file.increment_s, channel(section.sensor_channel, "sensor_channel"),
                        channel(section.actuator_channel, "actuator_channel")};
  fit::ScopeOptions options;
  options.carrier_hz = section.carrier_hz;
  options.sensor_delay = section.sensor_delay_s;
  options.sensor_delay_sd = section.sensor_delay_sd_s;
  ScopeEvidence evidence;
  try {
    evidence.events = fit::find_scope_events(trace, options);
  } catch (const fit::DataError& error) {
    throw InvalidInput(fmt::format("{}: {}", run.scope->string(), error.what()));
  }
  evidence.sensor = fit::sensor_clock(evidence.events, options);
  evidence.tie = section.tie == "trigger" ? ScopeTie::trigger
                 : section.tie == "lamp"  ? ScopeTie::lamp
                                          : ScopeTie::sensor;
  evidence.tie_sd = section.tie_sd_s;
  evidence.trigger_time = section.trigger_time_s ? section.trigger_time_s : trigger_time_of(track);
  if (evidence.tie == ScopeTie::trigger && !evidence.trigger_time)
    throw InvalidInput(
        fmt::format("{}: run \"{}\": the recording does not say when it was triggered; give [scope] "
                    "trigger_time_s, the trigger's place in the recording's time",
                    run.place, run.name));
  if (evidence.tie == ScopeTie::lamp && track.lamp.time.empty())
    throw InvalidInput(fmt::format(
        "{}: run \"{}\": [scope] tie = \"lamp\" needs a lamp in the picture; give [camera] gate_px",
        run.place, run.name));
  return evidence;
}

/// The gate as it was in place of the gate as commanded.
void use_measured_gate(AnalysedRun& analysed) {
  const fit::GateTiming& gate = *analysed.measurement->gate;
  model::Scenario& scenario = analysed.scenario;
  scenario.friction.phase = gate.phi.value;
  scenario.friction.pulse_width = std::clamp(gate.dtau.value, 0.0, 2 * std::numbers::pi);
  Eigen::Matrix2d covariance;
  covariance << gate.phi.sd * gate.phi.sd, gate.covariance, gate.covariance, gate.dtau.sd * gate.dtau.sd;
  model::Scenario guess = scenario;
  guess.friction.nominal = 0.8 * scenario.drive.acceleration(0).norm() / scenario.drive.gravity;
  guess.friction.reduced = 0.2 * guess.friction.nominal;
  analysed.displacement.covariance += fit::displacement_covariance_of_gate(guess, covariance);
  fit::derive_alpha_and_v(analysed.displacement);
}

}  // namespace

RecordingJob job_for(const Campaign& campaign, const CampaignRun& run) {
  RecordingJob job;
  job.video = *run.video;
  job.frame_rate_hz = campaign.camera.frame_rate_hz;
  job.mm_per_px = run.mm_per_px ? run.mm_per_px : campaign.camera.mm_per_px;
  if (job.mm_per_px)
    job.mm_per_px_sd = run.mm_per_px ? 0 : campaign.camera.mm_per_px_sd;
  else if (campaign.camera.calibration)
    job.calibration = campaign.camera.calibration;
  else
    job.diameter_mm = campaign.diameter_mm;
  job.diameter_sd_mm = campaign.diameter_sd_mm;
  job.height_mm = campaign.height_mm;
  job.working_distance_mm = campaign.camera.working_distance_mm;
  job.xi_axis_rad = campaign.camera.xi_axis_rad;
  if (const auto disc = run.disc_px ? run.disc_px : campaign.camera.disc_px)
    job.track.target = {vision::Target::Kind::disc, *disc, {}};
  const auto marker = run.marker_px ? run.marker_px : campaign.camera.marker_px;
  if (!run.free_slide)
    job.track.marker = marker ? vision::MarkerChoice{vision::MarkerChoice::Kind::circle, *marker}
                              : vision::MarkerChoice{campaign.camera.marker, {}};
  if (!run.free_slide) job.track.gate = campaign.camera.gate_px;
  job.track.first_frame = run.first_frame;
  job.track.last_frame = run.last_frame;
  return job;
}

AnalysedRun analyse(const Campaign& campaign, const CampaignRun& run, std::optional<TrackFile> track) {
  AnalysedRun analysed;
  analysed.run = &run;
  if (track && !run.free_slide) {
    GivenConditions given;
    given.angular_frequency =
        run.angular_frequency ? run.angular_frequency : campaign.platform.angular_frequency;
    given.amplitude = run.amplitude ? run.amplitude : campaign.platform.amplitude;
    given.phase_shift = campaign.platform.phase_shift;
    given.phase_at_zero = run.phase_at_zero;
    given.phi = run.phi;
    given.dtau = run.dtau;
    if (run.scope) given.scope = scope_of(campaign, run, *track);
    given.cycles = run.cycles;
    analysed.measurement = measure_run(run.name, *track, given);
  }
  const RunMeasurement* measured = analysed.measurement ? &*analysed.measurement : nullptr;
  model::Scenario& scenario = analysed.scenario;
  scenario.drive = drive_of(campaign, run, measured, analysed.amplitude_from_track);
  scenario.friction.phase = run.phi;
  scenario.friction.pulse_width = run.dtau;
  scenario.start = run.start;
  scenario.cycles = run.cycles;
  if (measured != nullptr) {
    if (!measured->displacement)
      throw InvalidInput(
          fmt::format("{}: run \"{}\": angular_frequency_rad_s is neither given nor seen; give it in "
                      "[platform], or `marker_px` in [camera]",
                      run.place, run.name));
    analysed.displacement = *measured->displacement;
    scenario.cycles = analysed.displacement.cycles;
    scenario.start_phase = measured->phase_source == "assumed 0" && run.start_phase
                               ? *run.start_phase
                               : measured->phase_at_start;
    if (measured->gate) use_measured_gate(analysed);
  } else if (!run.free_slide) {
    analysed.displacement = fit::displacement_from_alpha_v({*run.alpha, *run.alpha_sd}, {*run.v, *run.v_sd},
                                                           scenario.drive.angular_frequency, run.cycles);
    scenario.start_phase = run.start_phase.value_or(0);
  }
  analysed.track = std::move(track);
  return analysed;
}

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
  for (const auto& [parameter, value] : campaign.fit.start) problem.start[parameter] = si(parameter, value);
  for (const auto& [parameter, prior] : campaign.fit.prior)
    problem.prior[parameter] = {si(parameter, prior.mean), si(parameter, prior.sd)};

  double scale_sd = 0;
  int scaled = 0;
  for (const AnalysedRun& run : runs) {
    if (!run.failure.empty()) continue;
    const std::string& name = run.run->name;
    if (run.track && run.track->mm_per_px && *run.track->mm_per_px > 0) {
      scale_sd += run.track->mm_per_px_sd.value_or(0) / *run.track->mm_per_px;
      ++scaled;
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
  problem.scale_sd = scaled > 0 ? scale_sd / scaled : 0;
  return problem;
}

}  // namespace tribotrack::apps
