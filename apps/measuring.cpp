#include "apps/measuring.h"

#include <fmt/format.h>

#include <cmath>

#include "apps/errors.h"

namespace tribotrack::apps {

namespace {

/// The sense of turning a campaign states must be the one seen: a mirrored picture gives mirrored angles.
void require_same_sense(const std::string& name, const fit::PlatformMotion& seen, double phase_shift) {
  const double stated = std::sin(phase_shift), measured = std::sin(seen.phase_shift.value);
  if (stated * measured >= 0 || std::abs(measured) < 5 * seen.phase_shift.sd) return;
  throw InvalidInput(
      fmt::format("{}: the platform is seen to turn {}, but phase_shift_rad = {:.4g} means {}; set "
                  "phase_shift_rad = {:.4g}, or check "
                  "whether the picture is mirrored",
                  name, seen.clockwise ? "clockwise" : "counter-clockwise", phase_shift,
                  seen.clockwise ? "counter-clockwise" : "clockwise", -phase_shift));
}

void compare(std::vector<std::string>& warnings, const std::string& name, const char* what,
             const fit::Estimate& seen, double given) {
  const double off = std::abs(seen.value - given);
  if (off > 5 * seen.sd && off > 2e-3 * std::abs(given))
    warnings.push_back(
        fmt::format("{}: the marker says {} = {:.6g} +- {:.2g}, the campaign {:.6g}: the given value is "
                    "used; leave it out to use the measured one",
                    name, what, seen.value, seen.sd, given));
}

void put(Json& json, const std::string& name, const fit::Estimate& estimate, double unit = 1) {
  json[name] = estimate.value / unit;
  json[name + "_sd"] = estimate.sd / std::abs(unit);
}

}  // namespace

RunMeasurement measure_run(const std::string& name, const TrackFile& track, const GivenConditions& given) {
  if (track.table.time.size() < 2)
    throw fit::DataError(fmt::format("{}: the part was tracked in {} frames; nothing can be measured", name,
                                     track.table.time.size()));
  RunMeasurement m;
  m.platform = fit::measure_platform_motion(track.table);
  if (m.platform && given.phase_shift) require_same_sense(name, *m.platform, *given.phase_shift);
  if (m.platform && given.angular_frequency)
    compare(m.warnings, name, "angular_frequency_rad_s", m.platform->angular_frequency,
            *given.angular_frequency);
  if (m.platform && given.amplitude && *given.amplitude > 0) {
    const fit::Estimate mm{m.platform->amplitude.value * 1e3, m.platform->amplitude.sd * 1e3};
    compare(m.warnings, name, "amplitude_mm", mm, *given.amplitude * 1e3);
  }

  if (given.angular_frequency)
    m.angular_frequency = fit::Estimate{*given.angular_frequency, 0};
  else if (m.platform)
    m.angular_frequency = m.platform->angular_frequency;

  const double start = track.table.time.front();
  if (m.platform) {
    // The measured w carries the measured phase to the start: they were fitted together.
    m.phase_at_start = m.platform->angular_frequency.value * start + m.platform->phase_at_zero.value;
    m.phase_source = "marker";
  } else {
    m.phase_at_start =
        given.phase_at_zero.value_or(0) + (m.angular_frequency ? m.angular_frequency->value * start : 0);
    m.phase_source = given.phase_at_zero ? "given" : "assumed 0";
  }
  if (m.angular_frequency) {
    try {
      m.displacement = fit::measure_displacement(track.table, *m.angular_frequency, given.cycles);
    } catch (const fit::DataError& error) {
      throw fit::DataError(fmt::format("{}: {}", name, error.what()));
    }
  }
  return m;
}

Json measurement_json(const RunMeasurement& m, const TrackFile& track) {
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
    json["sense"] = m.platform->clockwise ? "clockwise" : "counter-clockwise";
  } else if (m.angular_frequency) {
    put(json, "angular_frequency_rad_s", *m.angular_frequency);
  }
  json["phase_at_start_rad"] = m.phase_at_start;
  json["phase_source"] = m.phase_source;
  if (track.mm_per_px) {
    json["mm_per_px"] = *track.mm_per_px;
    json["mm_per_px_sd"] = track.mm_per_px_sd.value_or(0);
  }
  json["frames"] = track.frames;
  json["tracked"] = track.table.time.size();
  json["warnings"] = m.warnings;
  return json;
}

}  // namespace tribotrack::apps
