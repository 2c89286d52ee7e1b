// A free slide by itself: how fast the part slows down, when it stops, how fast it turns.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "apps/files/track_file.h"
#include "apps/text/json.h"
#include "fit/fit_result.h"

namespace tribotrack::apps {

struct SlideMeasurement {
  fit::SlideResult slide;
  double gravity = 9.81;            ///< m/s^2, by which mu1 follows from the deceleration
  fit::Estimate deceleration;       ///< m/s^2, mu1 g: of the sliding part before any spin spares it friction
  double deceleration_slow_sd = 0;  ///< m/s^2, of the track's slow errors; 0 where none were seen
  bool stop_seen = false;           ///< the part rests before the track ends
  std::vector<std::string> warnings;
};

/// Throws fit::DataError where the track shows no sliding; `name` stands in its message.
SlideMeasurement measure_slide(const std::string& name, const Track& track, double gravity);

/// The object `measure --json` prints of a free slide.
Json slide_measurement_json(const SlideMeasurement& measurement, const Track& track);

// What `measure` makes of one track: the motion of a driven part, or a free slide.

/// Each a flag of the command line and a keyword in Python; empty: not given.
struct MeasureChoices {
  std::optional<double> omega_rad_s, epsilon_rad, cycles;
  std::optional<double> gravity_m_s2;  ///< of a free slide
  bool free_slide = false;             ///< else where no drive is given or seen
};

struct TrackMeasurement {
  Json json;  ///< the object `measure --json` prints
  std::vector<std::string> warnings;
  Json configuration;   ///< for the meta file
  std::string failure;  ///< what fails its quality gate; empty: nothing
};

/// What the track shows is judged first (fit/motion.h): `motion` and `motion_sentence`. Without a drive that
/// is given or seen mu1 follows where it shows an even slide, else the failure says what it shows and what to
/// do; with one, alpha and v, and the failure where the part shows another motion. `name` begins messages.
/// Throws UsageError for choices that are out of range or contradict each other, InvalidInput and
/// fit::DataError where the track does not show what is asked for.
TrackMeasurement measure_track(const std::string& name, const Track& track, const MeasureChoices& choices);

}  // namespace tribotrack::apps
