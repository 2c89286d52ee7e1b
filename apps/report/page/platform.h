// The report's section on the platform and the gate: orbit, phase and brightness of every run.
#pragma once

#include <string>

#include "apps/report/data/data.h"

namespace tribotrack::apps {

/// One line of numbers and up to three drawings a run: orbit, phase residual over time, brightness over
/// phase.
std::string platform_section(const ReportData& data);

}  // namespace tribotrack::apps
