// What one track tells, for a person: rounded where the standard deviation says, with units.
#pragma once

#include <string>

#include "apps/campaign/measure_run.h"

namespace tribotrack::apps {

/// Lines of displacement, platform, gate and scale, each ending in a newline. Every digit is in
/// measurement_json().
std::string measurement_text(const RunMeasurement& measurement, const TrackFile& track);

}  // namespace tribotrack::apps
