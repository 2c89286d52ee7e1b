// The results of a campaign as tables for other programs and as text to paste: what `run` leaves beside the
// page.
#pragma once

#include <string>

#include "apps/report/data/data.h"

namespace tribotrack::apps {

/// One row a run, all digits: number, name, conditions, alpha and v measured and modelled with residuals in
/// sd, platform, frames, failure.
std::string runs_csv(const ReportData& data);

/// One row a parameter, all digits: estimate, sd, the 95 % intervals, then correlations with the others.
std::string parameters_csv(const ReportData& data);

/// One block to paste: verdict, values, goodness of fit, budget, warnings, methods.
std::string report_text(const ReportData& data);

}  // namespace tribotrack::apps
