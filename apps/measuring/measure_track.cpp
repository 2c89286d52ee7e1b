#include "apps/measuring/measure_track.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "apps/measuring/measure_run.h"
#include "apps/measuring/measure_slide.h"
#include "apps/measuring/measure_text.h"
#include "apps/program/errors.h"

namespace tribotrack::apps {

namespace {

GivenConditions given_by(const MeasureChoices& choices) {
  if (choices.omega_rad_s && !(*choices.omega_rad_s > 0))
    throw UsageError("--omega-rad-s must be greater than 0");
  GivenConditions given;
  given.angular_frequency = choices.omega_rad_s;
  given.phase_shift = choices.epsilon_rad;
  if (choices.cycles) {
    if (!(*choices.cycles >= 1 && *choices.cycles <= 1e6) || *choices.cycles != std::floor(*choices.cycles))
      throw UsageError(fmt::format("--cycles must be a whole number, 1 to 1000000, not {}", *choices.cycles));
    given.cycles = static_cast<int>(*choices.cycles);
  }
  if (choices.free_slide && choices.omega_rad_s)
    throw UsageError("--free-slide and --omega-rad-s contradict each other: a free slide's platform rests");
  return given;
}

/// A part that slides on the resting platform: no drive is given, none is seen.
TrackMeasurement measure_free_slide(const std::string& name, const TrackFile& track,
                                    const MeasureChoices& choices) {
  const double gravity = choices.gravity_m_s2.value_or(9.81);
  if (!(gravity > 0)) throw UsageError("--gravity-m-s2 must be greater than 0");
  std::optional<SlideMeasurement> m;
  try {
    m = measure_slide(name, track, gravity);
  } catch (const fit::DataError& no_slide) {
    if (choices.free_slide) throw;
    throw InvalidInput(
        fmt::format("{}: the platform's frequency is neither given nor seen in the track, and it is no free "
                    "slide either ({}); "
                    "give --omega-rad-s, or track with --marker",
                    name, no_slide.what()));
  }
  return {slide_measurement_json(*m, track),
          slide_measurement_text(*m, track),
          m->warnings,
          {{"free_slide", true}, {"gravity_m_s2", gravity}},
          ""};
}

}  // namespace

TrackMeasurement measure_track(const std::string& name, const TrackFile& track,
                               const MeasureChoices& choices) {
  const GivenConditions given = given_by(choices);
  if (choices.free_slide) return measure_free_slide(name, track, choices);
  RunMeasurement measured = measure_run(name, track, given);
  for (std::string& difference : differences(name, measured, given))
    measured.warnings.push_back(std::move(difference));
  if (!measured.displacement) return measure_free_slide(name, track, choices);
  if (choices.gravity_m_s2)
    throw UsageError("--gravity-m-s2 belongs to free slides; this track shows a moving platform");
  TrackMeasurement result{measurement_json(measured, track),
                          measurement_text(measured, track),
                          measured.warnings,
                          {{"omega_rad_s", optional_json(given.angular_frequency)}, {"cycles", given.cycles}},
                          ""};
  if (measured.coded && measured.coded->exceeds)
    result.failure = fmt::format(
        "{}: the coder's attenuation or delay exceeds the interval of what the track tells", name);
  return result;
}

}  // namespace tribotrack::apps
