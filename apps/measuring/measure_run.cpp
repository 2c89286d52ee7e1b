#include "apps/measuring/measure_run.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "apps/program/errors.h"
#include "apps/text/number_text.h"
#include "fit/conditions.h"

namespace tribotrack::apps {

namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kNear = 0.1;

struct Slip {
  double factor;  ///< from what was given to what was meant
  const char* given_as;
};

/// A length in mm.
const std::vector<Slip> kLengths = {{1e3, "in metres"}, {10, "in cm"}, {25.4, "in inches"}, {1e-3, "in um"}};

std::vector<Slip> slips_of(const std::string& quantity) {
  if (quantity == "angular_frequency_rad_s")
    return {{2 * kPi, "in Hz"},
            {2 * kPi / 60, "in revolutions per minute"},
            {kPi / 180, "in degrees per second"},
            {1 / (2 * kPi), "times 2 pi"},
            {2e3 * kPi, "in kHz"}};
  if (quantity == "phase_shift_rad") return {{kPi / 180, "in degrees"}, {2 * kPi, "in turns"}};
  std::vector<Slip> slips = kLengths;
  if (quantity.starts_with("amplitude")) {
    slips.push_back({0.5, "peak to peak"});
    slips.push_back({std::numbers::sqrt2, "as its root mean square"});
  }
  if (quantity == "diameter_mm") slips.push_back({2, "as its radius"});
  return slips;
}

std::string unit_of(const std::string& quantity) {
  return quantity.ends_with("_rad_s") ? "rad/s" : quantity.ends_with("_rad") ? "rad" : "mm";
}

bool is_near(const std::string& quantity, double meant, double measured) {
  if (quantity.ends_with("_rad"))
    return std::abs(std::remainder(meant - measured, 2 * kPi)) < kNear * kPi / 2;
  return std::abs(meant - measured) < kNear * std::abs(measured);
}

}  // namespace

std::string likely_slip(const std::string& quantity, double given, double measured) {
  for (const auto& [factor, given_as] : slips_of(quantity))
    if (is_near(quantity, given * factor, measured))
      return fmt::format("{:.4g} is {:.4g} {} {}", given, given * factor, unit_of(quantity), given_as);
  if (quantity == "angular_frequency_rad_s" && given > 0)
    for (const auto& [seconds, name] : {std::pair{1.0, "s"}, std::pair{1e-3, "ms"}})
      if (const double meant = 2 * kPi / (given * seconds); is_near(quantity, meant, measured))
        return fmt::format("{:.4g} {} is the period of {:.4g} rad/s", given, name, meant);
  return "";
}

namespace {

/// Coded motion of 0.05 to 0.7 px a frame came back too small by up to 0.3 to 0.6 of the play's half width
/// over the amplitude, where a play alone does less: what follows late is smoothed as well.
constexpr double kSmoothed = 0.5;
constexpr double kQuantile95 = 1.96;  ///< two-sided, of a normal number
constexpr double kFelt = 0.1;         ///< of an sd: what is less is not said
constexpr double kContradicts = 3.5;  ///< sd: one of two thousand by chance

/// The sense of turning a campaign states must be the one seen: a mirrored picture gives mirrored angles.
void require_same_sense(const std::string& name, const fit::PlatformMotion& seen, double phase_shift) {
  const double stated = std::sin(phase_shift), measured = std::sin(seen.phase_shift.value);
  if (stated * measured >= 0 || std::abs(measured) < 5 * seen.phase_shift.sd) return;
  throw InvalidInput(
      "{}: the platform is seen to turn {}, but phase_shift_rad = {:.4g} means {}; set phase_shift_rad = "
      "{:.4g}, or check whether the picture is mirrored",
      name, seen.clockwise ? "clockwise" : "counter-clockwise", phase_shift,
      seen.clockwise ? "counter-clockwise" : "clockwise", -phase_shift);
}

/// The platform's phase over the camera's time; nullopt where it is unknown.
std::optional<fit::PhaseClock> clock_of(const RunMeasurement& m, const GivenConditions& given) {
  if (m.platform)
    return fit::PhaseClock{m.platform->angular_frequency.value, m.platform->phase_at_zero.value,
                           m.platform->phase_at_middle.sd};
  if (m.angular_frequency && given.phase_at_zero)
    return fit::PhaseClock{m.angular_frequency->value, *given.phase_at_zero, 0};
  return std::nullopt;
}

void note_against_command(const std::string& name, const GivenConditions& given, RunMeasurement& m) {
  const fit::GateTiming& gate = *m.gate;
  constexpr double kSet = kPi / 180;  ///< rad: as well as angles are set
  const auto compare = [&](const char* what, const fit::Estimate& seen,
                           const std::optional<double>& commanded, const char* look) {
    if (!commanded) return false;
    const double off = std::remainder(seen.value - *commanded, 2 * kPi);
    if (std::abs(off) <= std::max(kContradicts * std::hypot(seen.sd, kSet), 0.05)) return false;
    m.warnings.push_back(fmt::format(
        "{}: the {} shows {} = {} rad, commanded was {:.4f}: that which is known better is used{}", name,
        gate.source, what, quoted(seen.value, seen.sd), *commanded, look));
    return true;
  };
  m.phi_contradicts = compare(
      "phi", gate.phi, given.phi,
      "; where all runs differ alike look at the camera's direction (xi_axis_rad), the trigger's time or "
      "the sensor's edge");
  compare("dtau", gate.dtau, given.dtau, "");
}

/// Counts all that a play of the mark's size does.
void allow_for_coding(const std::string& name, const Track& track, RunMeasurement& m) {
  if (!track.coding || !m.platform) return;
  fit::PlatformMotion& platform = *m.platform;
  CodedMotion coded{.coder = track.coding->coder};
  const double metre_per_px = track.mm_per_px.value_or(0) * 1e-3;
  const double amplitude = std::max(platform.amplitude.value, platform.amplitude_y.value);
  const double half_width = track.coding->mark_play * metre_per_px;
  const auto seen = fit::seen_through_play(amplitude, half_width);
  coded.attenuation = std::max(seen.attenuation, kSmoothed * half_width / amplitude);
  coded.delay = seen.delay;
  if (!(coded.attenuation > 0 || coded.delay > 0)) return;
  coded.exceeds = coded.delay > kQuantile95 * platform.phase_at_middle.sd ||
                  coded.attenuation * platform.amplitude.value > kQuantile95 * platform.amplitude.sd;
  const bool felt = coded.delay > kFelt * platform.phase_at_middle.sd ||
                    coded.attenuation * platform.amplitude.value > kFelt * platform.amplitude.sd;
  for (fit::Estimate* length : {&platform.amplitude, &platform.amplitude_y})
    length->sd = std::hypot(length->sd, coded.attenuation * length->value);
  for (fit::Estimate* phase : {&platform.phase_at_zero, &platform.phase_at_middle})
    phase->sd = std::hypot(phase->sd, coded.delay);
  m.coded = coded;
  if (felt) m.warnings.push_back(fmt::format("{}: {}", name, coded.sentence()));
}

/// phi and dtau from lamp or trace. The lamp is tied to the camera by itself; a trace by a trigger, or else
/// it counts from its own sensor.
void measure_gate(const std::string& name, const Track& track, const GivenConditions& given,
                  RunMeasurement& m) {
  const auto warn = [&](const std::string& what) { m.warnings.push_back(name + ": " + what); };
  const auto take = [&](const fit::GateMeasurement& seen, const char* what, const char* reference) {
    if (seen.timing) {
      m.gate = seen.timing;
      m.gate_reference = reference;
    } else {
      warn(fmt::format("{} does not determine the gate: {}; phi and dtau are taken as commanded", what,
                       seen.why_not));
    }
  };
  if (!track.lamp.time.empty()) {
    if (m.phase_clock)
      take(fit::measure_gate(track.lamp, *m.phase_clock), "the gate LED (gate_px)", "camera");
    else
      warn(
          "the gate LED is seen, but the phase of the platform is unknown: phi and dtau are taken as "
          "commanded; give a marker, or phase_at_zero_rad");
  }
  if (given.lamp && track.lamp.time.empty())
    warn(
        "the gate LED (gate_px) was not read, since the part passes over it: phi and dtau are taken as "
        "commanded; correct gate_px");
  if (!given.scope) {
    if (m.gate) note_against_command(name, given, m);
    return;
  }
  const ScopeEvidence& scope = *given.scope;
  if (m.gate) {  // the lamp gave phi in the camera's own phase
    const fit::PhaseClock any{m.phase_clock->angular_frequency, 0, 0};
    if (const auto seen = fit::gate_from_scope(scope.events, any); seen.timing) {
      const fit::GateTiming lamp = *m.gate;
      m.gate->dtau = seen.timing->dtau;
      m.gate->covariance = 0;
      m.gate->source = "lamp and scope";
      if (std::abs(lamp.dtau.value - seen.timing->dtau.value) >
          5 * std::hypot(lamp.dtau.sd, seen.timing->dtau.sd) + 0.01)
        warn(
            fmt::format("the gate LED shows dtau = {:.4f} rad, the oscilloscope {:.4f}: the oscilloscope's "
                        "is used; does the LED follow the actuator's gate?",
                        lamp.dtau.value, seen.timing->dtau.value));
    }
  } else if (scope.tie == "trigger" && scope.trigger_time && m.phase_clock) {
    fit::PhaseClock clock = *m.phase_clock;
    clock.phase_at_zero += clock.angular_frequency * *scope.trigger_time;
    take(fit::gate_from_scope(scope.events, clock, scope.tie_sd), "the oscilloscope", "camera");
  } else if (scope.sensor) {
    take(fit::gate_from_scope(scope.events, scope.sensor->clock), "the oscilloscope", "sensor");
  } else {
    warn(
        "the oscilloscope trace holds no reference pulses and is not tied to the camera: phi and dtau are "
        "taken as commanded; name [scope] sensor_channel, or tie = \"trigger\"");
  }
  if (m.gate) note_against_command(name, given, m);
}

bool is_slip(double given, double measured) {
  return std::abs(measured / given - 1) > fit::kSlipShare;
}

void put(Json& json, const std::string& name, const fit::Estimate& estimate, double unit = 1) {
  json[name] = estimate.value / unit;
  json[name + "_sd"] = estimate.sd / std::abs(unit);
}

}  // namespace

RunMeasurement measure_run(const std::string& name, const Track& track, const GivenConditions& given) {
  const std::size_t shown = track.table.time.size() + track.without_mark;
  if (2 * track.without_mark > shown)
    throw fit::DataError(
        fmt::format("{}: of {} frames that show the part {} do not show the platform's mark or tag; give one "
                    "that stays in the picture, or track without it",
                    name, shown, track.without_mark));
  if (track.table.time.size() < 2)
    throw fit::DataError(fmt::format("{}: the part was tracked in {} frames; nothing can be measured", name,
                                     track.table.time.size()));
  RunMeasurement m;
  m.platform = fit::measure_platform_motion(track.table);
  if (track.without_mark > 0)
    m.warnings.push_back(fmt::format("{}: {} frames are left out that do not show the platform's mark or tag",
                                     name, track.without_mark));
  if (m.platform &&
      m.platform->drift.norm() > 2 * m.platform->amplitude.value + 2 * m.platform->amplitude_y.value)
    m.warnings.push_back(fmt::format(
        "{}: what is taken for the platform drifts by {:.2g} mm in the recording, farther than it circles: "
        "does the camera move, or is the mark not fixed to the platform? The part's motion is counted from "
        "it",
        name, 1e3 * m.platform->drift.norm()));
  allow_for_coding(name, track, m);
  if (m.platform && given.phase_shift) require_same_sense(name, *m.platform, *given.phase_shift);
  if (given.angular_frequency)
    m.angular_frequency = fit::Estimate{*given.angular_frequency, 0};
  else if (m.platform)
    m.angular_frequency = m.platform->angular_frequency;

  const double start = m.start_time = track.table.time.front();
  if (m.platform) {
    // The measured w carries the measured phase to the start: they were fitted together.
    m.phase_at_start = m.platform->angular_frequency.value * start + m.platform->phase_at_zero.value;
    m.phase_source = track.platform_from_texture ? "texture" : "marker";
  } else {
    m.phase_at_start =
        given.phase_at_zero.value_or(0) + (m.angular_frequency ? m.angular_frequency->value * start : 0);
    m.phase_source = given.phase_at_zero ? "given" : "assumed 0";
  }
  m.phase_clock = clock_of(m, given);
  measure_gate(name, track, given, m);
  if (m.platform && m.platform->frequency_drifts())
    m.warnings.push_back(fmt::format(
        "{}: the platform's frequency drifts by {} rad/s^2, {:.2g} % of w over the recording; w is its mean",
        name, quoted(m.platform->frequency_drift->value, m.platform->frequency_drift->sd),
        100 * std::abs(m.platform->frequency_drift->value) * (track.table.time.back() - start) /
            m.platform->angular_frequency.value));
  if (m.angular_frequency) {
    try {
      m.displacement = fit::measure_displacement(track.table, *m.angular_frequency, given.cycles);
    } catch (const fit::DataError& error) {
      if (!m.platform || !is_slip(m.angular_frequency->value, m.platform->angular_frequency.value))
        throw fit::DataError(fmt::format("{}: {}", name, error.what()));
      // The given w is no w of this recording: what it does show can be told.
      m.angular_frequency = m.platform->angular_frequency;
      m.displacement = fit::measure_displacement(track.table, *m.angular_frequency, given.cycles);
    }
  }
  return m;
}

std::string broken_motion(const Track& track, const RunMeasurement& m) {
  if (!m.platform || !m.platform->broken) return "";
  const auto& [row, moved, ahead] = *m.platform->broken;
  const std::vector<double>& time = track.table.time;
  const double interval = (time.back() - time.front()) / static_cast<double>(time.size() - 1);
  return fmt::format(
      "the platform's motion breaks at frame {}: from there on it is {:.2g} frames ahead of its time and "
      "{:.2g} by {:.2g} mm aside, as where frames are missing in silence or the camera was knocked; track "
      "the frames before or after it (--frames)",
      track.table.frame[row], ahead / interval, 1e3 * moved.x(), 1e3 * moved.y());
}

std::vector<std::string> differences(const std::string& name, const RunMeasurement& measured,
                                     const GivenConditions& given) {
  if (!measured.platform || !given.angular_frequency) return {};
  const fit::Estimate& seen = measured.platform->angular_frequency;
  const double off = std::abs(seen.value - *given.angular_frequency);
  if (off <= 5 * seen.sd || off <= 2e-3 * *given.angular_frequency) return {};
  const bool used = measured.angular_frequency->value == *given.angular_frequency;
  const std::string slip = likely_slip("angular_frequency_rad_s", *given.angular_frequency, seen.value);
  return {fmt::format("{}: the marker shows angular_frequency_rad_s = {}, given is {:.6g}{}: {}", name,
                      quoted(seen.value, seen.sd), *given.angular_frequency,
                      slip.empty() ? "" : " (" + slip + ")",
                      used ? "the given value is used; leave it out to use the measured one"
                           : "the measured value is used, the given one leaves nothing to measure")};
}

std::string CodedMotion::sentence() const {
  return fmt::format(
      "the codec ({}) attenuates the platform's motion by up to {:.2g} % and delays it by up to {:.2g} rad: "
      "the intervals include both{}",
      coder, 100 * attenuation, delay,
      exceeds ? ", and both together dominate them: film uncompressed or with less compression" : "");
}

bool lamp_gave_phi(const fit::GateTiming& gate) {
  return gate.on_level != gate.off_level;
}

void put_recording(Json& json, const Track& track, const std::vector<std::string>& warnings) {
  if (track.mm_per_px) {
    json["mm_per_px"] = *track.mm_per_px;
    json["mm_per_px_sd"] = track.mm_per_px_sd.value_or(0);
  }
  json["frames"] = track.frames;
  json["tracked"] = track.table.time.size();
  json["frames_missing"] = track.missing;
  json["frames_repeated"] = track.repeats;
  json["warnings"] = warnings;
}

Json measurement_json(const RunMeasurement& m, const Track& track) {
  Json json = Json::object();
  const double scale_sd = track.mm_per_px ? track.mm_per_px_sd.value_or(0) / *track.mm_per_px : 0;
  if (m.displacement) {
    const fit::Displacement d = fit::with_scale_sd(*m.displacement, scale_sd);
    put(json, "dx_mm", {d.vector.x(), std::sqrt(d.covariance(0, 0))}, 1e-3);
    put(json, "dy_mm", {d.vector.y(), std::sqrt(d.covariance(1, 1))}, 1e-3);
    json["cov_dx_dy_mm2"] = d.covariance(0, 1) * 1e6;
    if (d.alpha) put(json, "alpha_rad", *d.alpha);
    put(json, "v_mm_s", d.mean_velocity, 1e-3);
    json["cycles"] = d.cycles;
  }
  if (m.platform) {
    const fit::PlatformMotion platform = fit::with_scale_sd(*m.platform, scale_sd);
    put(json, "amplitude_mm", platform.amplitude, 1e-3);
    put(json, "amplitude_y_mm", platform.amplitude_y, 1e-3);
    put(json, "angular_frequency_rad_s", m.platform->angular_frequency);
    put(json, "phase_shift_rad", m.platform->phase_shift);
    put(json, "phase_at_zero_rad", m.platform->phase_at_zero);
    if (m.platform->frequency_drift)
      put(json, "angular_frequency_drift_rad_s2", *m.platform->frequency_drift);
    json["harmonics"] = Json::array();
    for (const fit::Harmonic& h : m.platform->harmonics) {
      Json entry = {{"order", h.order}, {"seen", h.seen()}};
      put(entry, "amplitude_mm", h.amplitude, 1e-3);
      put(entry, "amplitude_y_mm", h.amplitude_y, 1e-3);
      json["harmonics"].push_back(entry);
    }
    json["platform_residual_rms_mm"] = m.platform->residual_rms * 1e3;
    json["sense"] = m.platform->clockwise ? "clockwise" : "counter-clockwise";
  } else if (m.angular_frequency) {
    put(json, "angular_frequency_rad_s", *m.angular_frequency);
  }
  if (m.gate) {
    put(json, "phi_rad", m.gate->phi);
    put(json, "dtau_rad", m.gate->dtau);
    json["gate"] = {{"source", m.gate->source},
                    {"phi_counts_from", m.gate_reference},
                    {"cycles", m.gate->cycles},
                    {"partly_lit_frames", m.gate->partly_lit},
                    {"bracket_rad", m.gate->bracket},
                    {"edge_jitter_rad", m.gate->jitter},
                    {"cov_phi_dtau_rad2", m.gate->covariance}};
    if (lamp_gave_phi(*m.gate)) {
      json["gate"]["lamp_off_level"] = m.gate->off_level;
      json["gate"]["lamp_on_level"] = m.gate->on_level;
    }
  }
  if (m.coded)
    json["coding"] = {{"coder", m.coded->coder},
                      {"attenuation", m.coded->attenuation},
                      {"attenuation_sd", m.coded->attenuation},
                      {"delay_rad", m.coded->delay},
                      {"delay_rad_sd", m.coded->delay},
                      {"exceeds_interval", m.coded->exceeds}};
  json["phase_at_start_rad"] = m.phase_at_start;
  json["phase_source"] = m.phase_source;
  put_recording(json, track, m.warnings);
  return json;
}

}  // namespace tribotrack::apps
