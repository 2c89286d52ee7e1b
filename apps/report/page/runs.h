// The report page's parts that go run by run: pictures with the path over them, the table, the plan. HTML
// that reads the same without scripts and on paper.
#pragma once

#include <string>

#include "apps/report/data/data.h"

namespace tribotrack::apps {

/// Paths over the first frames (paper, fig. 11); a sentence where no run has a picture.
std::string picture_section(const ReportData& data);

std::string run_section(const ReportData& data);    ///< table of runs, failures, remarks
std::string audit_section(const ReportData& data);  ///< what the recordings say of their standard deviations
std::string plan_section(const ReportData& data);   ///< stages left out, and why

}  // namespace tribotrack::apps
