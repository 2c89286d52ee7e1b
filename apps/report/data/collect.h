// From the folder `run` leaves to the numbers of its report.
#pragma once

#include <string>

#include "apps/files/run_folder.h"
#include "apps/report/data/data.h"

namespace tribotrack::apps {

/// Reads fit.json, its meta file, the tracks and measurements. Throws InvalidInput naming what is missing.
ReportData collect_report(const RunFolder& folder);

/// The whole page.
std::string report_page_of(const RunFolder& folder);

}  // namespace tribotrack::apps
