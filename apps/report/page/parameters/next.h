// The report page's section on what to film next.
#pragma once

#include <string>

#include "apps/report/data/data.h"

namespace tribotrack::apps {

/// The runs that would narrow the intervals most, with the intervals predicted; empty where none was looked
/// for.
std::string next_section(const ReportData& data);

}  // namespace tribotrack::apps
