// The report page's section on whether the model is right: HTML that reads the same without scripts and on
// paper.
#pragma once

#include <string>

#include "apps/report/data/data.h"

namespace tribotrack::apps {

/// Chi-squared and runs test, runs and points that contradict the others, the friction models compared, and
/// the analyses that were not needed. Each only where there is something to show.
std::string check_section(const ReportData& data);

}  // namespace tribotrack::apps
