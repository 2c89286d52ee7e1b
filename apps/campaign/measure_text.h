// The measurement of one track as text for people: with units, rounded to the standard deviation.
#pragma once

#include <string>

#include "apps/campaign/measure_run.h"

namespace tribotrack::apps {

/// Lines of displacement, platform, gate and scale, each ending in a newline. Every digit is in
/// measurement_json().
std::string measurement_text(const RunMeasurement& measurement, const TrackFile& track);

}  // namespace tribotrack::apps
