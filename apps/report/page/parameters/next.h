// The report page's section on what to film next.
#pragma once

#include "apps/page/page.h"
#include "apps/report/data/data.h"

namespace tribotrack::apps {

/// The runs that would narrow the intervals most, with the intervals predicted; empty where none was looked
/// for.
PageSection next_section(const ReportData& data);

}  // namespace tribotrack::apps
