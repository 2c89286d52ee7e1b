// The measurement of one track as text for people: with units, rounded to the standard deviation.
#pragma once

#include <string>

#include "apps/files/traces/scope_file.h"
#include "apps/measuring/measure_run.h"
#include "apps/measuring/measure_track.h"
#include "apps/measuring/track_motion.h"
#include "apps/text/json.h"

namespace tribotrack::apps {

/// Lines of displacement, platform, gate and scale, each ending in a newline. Every digit is in
/// measurement_json().
std::string measurement_text(const RunMeasurement& measurement, const Track& track);

/// Its first line: what the track shows.
std::string motion_text(const TrackMotion& motion);

/// What `measure` prints of a slide.
std::string slide_measurement_text(const SlideMeasurement& measurement, const Track& track);

// What an oscilloscope's file holds, and what to write into [scope].

/// Layout, sampling and channels, each with what it looks like, and the lines of [scope] that say so: what
/// `probe trace.csv` prints.
std::string trace_text(const ScopeFile& trace);
Json trace_json(const ScopeFile& trace);

}  // namespace tribotrack::apps
