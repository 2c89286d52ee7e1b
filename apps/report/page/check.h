// The report page's section on whether the model is right: HTML that reads the same without scripts and on
// paper.
#pragma once

#include <string>

#include "apps/report/data/data.h"

namespace tribotrack::apps {

/// Chi-square and runs test in words, runs and points that contradict the others, the friction models
/// compared, and what was not tried. Each only where there is something to tell.
std::string check_section(const ReportData& data);

}  // namespace tribotrack::apps
