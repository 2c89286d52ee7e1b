// The report's section on the platform and the gate: orbit, phase and brightness of every run.
#pragma once

#include <string>

#include "apps/files/track_file.h"
#include "apps/report/data/data.h"

namespace tribotrack::apps {

/// What the figures need of one run's track. Empty where the platform is not seen to move.
ReportPlatform platform_of(const TrackFile& track);

/// One line of numbers and three drawings a run: orbit, phase left by the sine over time, brightness by
/// phase.
std::string platform_section(const ReportData& data);

}  // namespace tribotrack::apps
