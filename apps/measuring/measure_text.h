// The measurement of one track as text for people: with units, rounded to the standard deviation.
#pragma once

#include <string>

#include "apps/measuring/measure_run.h"
#include "apps/measuring/measure_slide.h"

namespace tribotrack::apps {

/// Lines of displacement, platform, gate and scale, each ending in a newline. Every digit is in
/// measurement_json().
std::string measurement_text(const RunMeasurement& measurement, const TrackFile& track);

/// What `measure` prints for people.
std::string slide_measurement_text(const SlideMeasurement& measurement, const TrackFile& track);

}  // namespace tribotrack::apps
