// The report: one self-contained HTML page of what a campaign gave.
#pragma once

#include <string>

#include "apps/files/run_folder.h"
#include "apps/report/data/from_results.h"

namespace tribotrack::apps {

/// The page of results in memory.
std::string report_page(const ReportInput& input);

/// The page of a folder that `run` has filled: the same bytes as report_page gave there. Throws InvalidInput.
std::string report_page_of(const RunFolder& folder);

}  // namespace tribotrack::apps
