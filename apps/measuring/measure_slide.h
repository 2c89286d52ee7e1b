// A free slide by itself: how fast the part slows down, when it stops, how fast it turns.
#pragma once

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
SlideMeasurement measure_slide(const std::string& name, const TrackFile& track, double gravity);

/// The object `measure --json` prints of a free slide.
Json slide_measurement_json(const SlideMeasurement& measurement, const TrackFile& track);

/// An entry of `slides` in fit.json.
Json slide_result_json(const fit::SlideResult& slide);

}  // namespace tribotrack::apps
