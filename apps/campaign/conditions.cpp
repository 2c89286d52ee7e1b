#include "apps/campaign/conditions.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <new>
#include <numbers>
#include <stdexcept>

#include "apps/campaign/shared_conditions.h"
#include "apps/files/traces/scope_file.h"
#include "apps/program/errors.h"

namespace tribotrack::apps {

namespace {

/// As the campaign gives it; what marks show of it is taken in with what all runs share
/// (shared_conditions.h).
model::Drive drive_of(const Campaign& campaign, const CampaignRun& run, bool seen) {
  const PlatformSection& given = campaign.platform;
  model::Drive drive;
  drive.gravity = given.gravity;
  drive.tilt_x = given.tilt_x;
  drive.tilt_y = given.tilt_y;
  if (run.free_slide) {
    drive.amplitude = drive.amplitude_y = 0;
    return drive;
  }
  const auto demand = [&](bool known, const char* key) {
    if (!known && !seen)
      throw InvalidInput(
          "{}: run \"{}\": {} is neither given nor seen; give it in [platform] (or the run), or `marker_px` "
          "in [camera]",
          run.place, run.name, key);
  };
  demand(run.amplitude || given.amplitude, "amplitude_mm");
  demand(run.angular_frequency || given.angular_frequency, "angular_frequency_rad_s");
  drive.angular_frequency =
      run.angular_frequency.value_or(given.angular_frequency.value_or(drive.angular_frequency));
  return drive;
}

/// The run's trace with its events. Throws InvalidInput naming the file.
ScopeEvidence scope_of(const Campaign& campaign, const CampaignRun& run, const Track& track,
                       const ScopeFile& file) {
  const ScopeSection& section = campaign.scope;
  const auto channel = [&](int number, const char* key) {
    if (number == 0) return std::vector<double>();
    if (static_cast<std::size_t>(number) > file.channels.size())
      throw InvalidInput(
          "{}:1: holds {} channel{}, but [scope] {} = {}{}", run.scope->string(), file.channels.size(),
          file.channels.size() == 1 ? "" : "s", key, number,
          file.layout == "Tektronix TDS"
              ? ": this oscilloscope writes a file for each; name both, scope = [\"CH1.csv\", \"CH2.csv\"]"
              : "");
    return file.channels[static_cast<std::size_t>(number) - 1];
  };
  fit::ScopeTrace trace{file.start_s, file.increment_s, channel(section.sensor_channel, "sensor_channel"),
                        channel(section.actuator_channel, "actuator_channel")};
  const fit::ScopeOptions options{.carrier_hz = section.carrier_hz,
                                  .sensor_delay = section.sensor_delay_s,
                                  .sensor_delay_sd = section.sensor_delay_sd_s};
  ScopeEvidence evidence;
  try {
    evidence.events = fit::find_scope_events(trace, options);
  } catch (const fit::DataError& error) {
    throw InvalidInput("{}: {} ([scope] sensor_channel = {}, actuator_channel = {})", run.scope->string(),
                       error.what(), section.sensor_channel, section.actuator_channel);
  }
  evidence.sensor = fit::sensor_clock(evidence.events, options);
  evidence.tie = section.tie;
  evidence.tie_sd = section.tie_sd_s;
  evidence.trigger_time = section.trigger_time_s ? section.trigger_time_s : track.trigger_time_s;
  if (evidence.tie == "trigger" && !evidence.trigger_time)
    throw InvalidInput(
        "{}: run \"{}\": the recording does not hold the time of its trigger; give [scope] trigger_time_s, "
        "the trigger's time in the recording",
        run.place, run.name);
  if (evidence.tie == "lamp" && track.lamp.time.empty())
    throw InvalidInput(
        "{}: run \"{}\": [scope] tie = \"lamp\" needs a lamp in the picture; give [camera] gate_px",
        run.place, run.name);
  return evidence;
}

/// One platform turned the sensor and moved the mark.
void require_same_frequency(const Run& analysed) {
  constexpr double kSame = 0.01;  // of w: the clocks of camera and oscilloscope agree to 1e-4
  if (!analysed.scope || !analysed.scope->sensor || !analysed.measurement || !analysed.measurement->platform)
    return;
  const double trace = analysed.scope->sensor->angular_frequency.value,
               recording = analysed.measurement->platform->angular_frequency.value;
  if (std::abs(trace / recording - 1) > kSame)
    throw InvalidInput(
        "{}: run \"{}\": the sensor in {} shows {:.4g} rad/s, the recording {:.4g} rad/s: is it the trace of "
        "another run? check `scope`",
        analysed.given.place, analysed.given.name, analysed.given.scope->string(), trace, recording);
}

/// A track that lost its part too often, or is none of a part, measures nothing, whoever made it and when.
void require_accepted(const CampaignRun& run, const Track& track) {
  if (track.accepted) return;
  std::string look;
  if (!track.inputs.empty() && track.inputs.front().path.extension() == ".csv") {
    std::filesystem::path overlay = track.inputs.front().path;
    overlay.replace_extension(".png");
    if (std::filesystem::exists(overlay)) look = fmt::format("look at {}; ", overlay.string());
  }
  if (track.rests_for_ever)
    throw InvalidInput(
        "{}: run \"{}\": the disc that was found by itself never moves; {}give disc_px = [X, Y, R]",
        run.place, run.name, look);
  throw InvalidInput(
      "{}: run \"{}\": the part was lost in {} of {} frames, more than allowed; {}give disc_px, or leave "
      "frames out with `frames`",
      run.place, run.name, track.lost_counted, track.frames, look);
}

/// Of a part that rests throughout a fit would make the least friction there can be.
void require_slide(const CampaignRun& run, const fit::TrackTable& track) {
  constexpr double kLeast = 10;  // of its sd: a shorter way tells no friction
  double way = 0, variance = 0;
  for (std::size_t k = 0; k < track.position.size(); ++k) {
    way = std::max(way, (track.position[k] - track.position.front()).norm());
    variance += 0.5 * track.covariance[k].trace() / static_cast<double>(track.position.size());
  }
  if (way > kLeast * std::sqrt(variance)) return;
  throw InvalidInput(
      "{}: run \"{}\": the part moves by {:.2g} mm in the frames used, hardly more than its positions are "
      "uncertain by ({:.2g} mm): it does not slide there; give `frames` in which it does, and disc_px as the "
      "first of them shows it",
      run.place, run.name, 1e3 * way, 1e3 * std::sqrt(variance));
}

/// Everything that is known of one run: given, or seen in its track.
GivenConditions given_for(const Campaign& campaign, const Run& analysed) {
  const CampaignRun& run = analysed.given;
  const PlatformSection& platform = campaign.platform;
  return {.lamp = campaign.camera.gate_px.has_value(),
          .angular_frequency = run.angular_frequency ? run.angular_frequency : platform.angular_frequency,
          .phase_shift = platform.phase_shift,
          .phase_at_zero = run.phase_at_zero,
          .phi = run.phi,
          .dtau = run.dtau,
          .scope = analysed.scope,
          .cycles = run.cycles};
}

/// What of the gate is taken as seen. A lamp beats a command only where it is known better: frames that meet
/// every cycle at the same phases leave wide open where an edge lies. A command of which nobody says how well
/// it is known is taken to hold to a degree, as angles are set.
void take_gate(const Campaign& campaign, Run& run) {
  constexpr double kCommand = std::numbers::pi / 180;
  run.gate.reset();
  run.gate_reference.clear();
  if (!run.measurement || !run.measurement->gate) return;
  run.gate = run.measurement->gate;
  run.gate_reference = run.measurement->gate_reference;
  if (!lamp_gave_phi(*run.gate)) return;
  std::string kept;
  const auto keeps = [&](const char* key, double given, const std::optional<double>& sd,
                         fit::Estimate& seen) {
    const double known = sd ? *sd : default_sd(campaign.fit.exact, key, given, run.given.digits);
    if (seen.sd < (known > 0 ? known : kCommand)) return false;
    kept += fmt::format("{}{} to {:.2g} rad", kept.empty() ? "" : " and ", key, seen.sd);
    seen = {given, known};
    run.gate->covariance = 0;
    return true;
  };
  const double bracket = run.gate->bracket;
  const bool phi = keeps("phi_rad", run.given.phi, run.given.phi_sd, run.gate->phi);
  // One that is told is taken in by its weight.
  const bool dtau =
      (phi || !run.given.dtau_sd) && keeps("dtau_rad", run.given.dtau, run.given.dtau_sd, run.gate->dtau);
  if (phi) run.gate_reference = "command";
  if (phi && dtau) run.gate.reset();
  if (kept.empty()) return;
  run.measurement->warnings.push_back(
      fmt::format("{}: the lamp shows {} only: taken as commanded{}", run.given.name, kept,
                  bracket > 0 ? fmt::format("; its frames leave open where in {:.2g} rad an edge lies, as "
                                            "those of a rate that is no multiple of the drive's do not",
                                            bracket)
                              : ""));
}

/// phi, dtau and the phase at the start, and what this run alone knows of them.
void settle_timing(const Campaign& campaign, Run& run) {
  take_gate(campaign, run);
  const fit::Timing timing = fit::settle_timing(evidence_of(campaign, run));
  run.scenario.friction.phase = timing.phi;
  run.scenario.friction.pulse_width = timing.dtau;
  run.scenario.start_phase = timing.start_phase;
  run.own = timing.own;
  if (!run.measurement) return;
  const auto note = [&](const char* key, const char* why) {
    run.measurement->warnings.push_back(fmt::format("{}: {} is not used: {}", run.given.name, key, why));
  };
  if (run.measurement->platform && run.given.start_phase_sd)
    note("start_phase_rad_sd", "the phase at the start was measured");
  if (run.gate && run.gate_reference == "camera" && run.given.phi_sd)
    note("phi_rad_sd",
         "phi was measured in the camera's own phase, the commanded one counts from the sensor");
}

}  // namespace

void measure(const Campaign& campaign, Run& run) {
  const CampaignRun& given = run.given;
  if (run.track) {
    Track& track = *run.track;
    require_accepted(given, track);
    run.inputs = track.inputs;
    if (given.scope && !given.free_slide) {
      require_trace(given);
      ScopeFile file = read_scope_file(*given.scope);
      run.inputs.push_back(file.input);
      if (given.second_scope) {
        const ScopeFile second = read_scope_file(*given.second_scope);
        run.inputs.push_back(second.input);
        add_channels(second, file);
      }
      run.scope = scope_of(campaign, given, track, file);
    }
    if (campaign.part.diameter_mm) track.table.radius = 0.5e-3 * *campaign.part.diameter_mm;
    if (given.free_slide) require_slide(given, track.table);
  }
  measure_again(campaign, run);
  require_same_frequency(run);
}

void require_trace(const CampaignRun& run) {
  for (const auto& file : {run.scope, run.second_scope})
    if (file && !std::filesystem::is_regular_file(*file))
      throw InvalidInput("{}: run \"{}\": there is no oscilloscope file {}; check `scope`", run.place,
                         run.name, file->string());
}

std::string failure_of(const CampaignRun& run, const std::exception& error) {
  if (dynamic_cast<const std::bad_alloc*>(&error) != nullptr)
    return fmt::format("{}: run \"{}\": out of memory; try fewer --threads", run.place, run.name);
  // Messages of run-time errors name their file or run; others were written without knowing of runs.
  std::string message = error.what();
  if (const std::string name = run.name + ": "; message.starts_with(name))
    return fmt::format("{}: run \"{}\": {}", run.place, run.name, message.substr(name.size()));
  if (dynamic_cast<const std::runtime_error*>(&error) != nullptr) return message;
  return fmt::format("{}: run \"{}\": {}", run.place, run.name, error.what());
}

void measure_again(const Campaign& campaign, Run& analysed) {
  const CampaignRun& run = analysed.given;
  analysed.measurement.reset();
  analysed.amplitude_from_track = false;
  analysed.scenario = {};
  analysed.own = {};
  if (analysed.track && !run.free_slide)
    analysed.measurement = measure_run(run.name, *analysed.track, given_for(campaign, analysed));
  const RunMeasurement* measured = analysed.measurement ? &*analysed.measurement : nullptr;
  model::Scenario& scenario = analysed.scenario;
  scenario.drive = drive_of(campaign, run, measured != nullptr && measured->platform);
  scenario.start = run.start;
  scenario.cycles = run.cycles;
  if (measured != nullptr) {
    if (const std::string broken = broken_motion(*analysed.track, *measured); !broken.empty())
      throw fit::DataError(fmt::format("{}: {}", run.name, broken));
    if (!measured->displacement)
      throw InvalidInput(
          "{}: run \"{}\": angular_frequency_rad_s is neither given nor seen; give it in [platform], or "
          "`marker_px` in [camera]",
          run.place, run.name);
    analysed.displacement = *measured->displacement;
    scenario.cycles = analysed.displacement.cycles;
  } else if (!run.free_slide) {
    analysed.displacement = fit::displacement_from_alpha_v({*run.alpha, *run.alpha_sd}, {*run.v, *run.v_sd},
                                                           scenario.drive.angular_frequency, run.cycles);
  }
  if (!run.free_slide) settle_timing(campaign, analysed);
}

}  // namespace tribotrack::apps
