// The report page's sections on single runs: the table of all, what their recordings say of sigma, what was
// left out, and each over time.
#pragma once

#include <string>
#include <vector>

#include "apps/page/page.h"
#include "apps/report/data/data.h"

namespace tribotrack::apps {

PageSection run_section(const ReportData& data);
PageSection audit_section(const ReportData& data);
PageSection plan_section(const ReportData& data);  ///< runs with the same plan in one table
/// `of_runs`: the figures of each run, in their order. Drawn when a reader opens the run.
PageSection detail_section(const ReportData& data, const std::vector<std::vector<Figure>>& of_runs);

// The paths over the first frames of their recordings.

/// All of them, or a sentence that there are none.
std::string pictures_of_runs(const ReportData& data);

/// The one to show first: of the run with the longest path; empty where no recording is at hand.
std::string first_picture(const ReportData& data);

}  // namespace tribotrack::apps
