// The report page's sections on single runs: the table of all, what their recordings say of sigma, what was
// left out, and each over time.
#pragma once

#include <vector>

#include "apps/page/page.h"
#include "apps/report/data/data.h"

namespace tribotrack::apps {

PageSection run_section(const ReportData& data);
PageSection audit_section(const ReportData& data);
PageSection plan_section(const ReportData& data);  ///< runs with the same plan in one table
/// `of_runs`: the figures of each run, in their order. Drawn when a reader opens the run.
PageSection detail_section(const ReportData& data, const std::vector<std::vector<Figure>>& of_runs);

}  // namespace tribotrack::apps
