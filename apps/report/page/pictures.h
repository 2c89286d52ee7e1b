// The paths over the first frames of their recordings.
#pragma once

#include <string>

#include "apps/report/data/data.h"

namespace tribotrack::apps {

/// All of them, or a sentence that there are none.
std::string pictures_of_runs(const ReportData& data);

/// The one to show first: of the run with the longest path; empty where no recording is at hand.
std::string first_picture(const ReportData& data);

}  // namespace tribotrack::apps
