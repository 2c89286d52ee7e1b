// The report page's table of parameters: covariance, profile and bootstrap intervals side by side.
#pragma once

#include <string>

#include "apps/report/data/data.h"

namespace tribotrack::apps {

/// One row for each parameter, a column for each kind of interval that any of them has, and beneath it what
/// each is and which covariance is printed.
std::string interval_table(const ReportData& data);

}  // namespace tribotrack::apps
