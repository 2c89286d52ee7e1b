// The report: one self-contained HTML page of what a campaign gave.
#pragma once

#include <string>
#include <vector>

#include "apps/files/run_folder.h"
#include "apps/report/data/from_results.h"

namespace tribotrack::apps {

/// The page of results in memory.
std::string report_page(const ReportInput& input);

struct ReportOfFolder {
  std::string page;
  std::vector<std::string>
      missing;  ///< what it does not show since the file is gone; stands on the page, too
};

/// The page of a folder that `run` has filled: the same bytes as report_page gave there. Throws InvalidInput.
ReportOfFolder report_of(const RunFolder& folder);

}  // namespace tribotrack::apps
