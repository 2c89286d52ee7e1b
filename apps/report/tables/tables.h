// The results of a campaign as tables: for other programs and as text to paste, which `run` leaves beside the
// page, and on the page itself.
#pragma once

#include <string>
#include <vector>

#include "apps/page/page.h"
#include "apps/report/data/data.h"

namespace tribotrack::apps {

/// One row a run, all digits: number, name, conditions, alpha and v measured and modelled with residuals in
/// sd, platform, frames, failure.
std::string runs_csv(const ReportData& data);

/// One row a parameter, all digits: estimate, sd, the 95 % intervals, then correlations with the others.
std::string parameters_csv(const ReportData& data);

/// One block to paste: verdict, values, goodness of fit, budget, warnings, methods.
std::string report_text(const ReportData& data);

// The report page's section on whether the model is right: HTML that reads the same without scripts and on
// paper.

/// Chi-squared, residuals, runs and points that contradict the others, the friction models
/// compared, and the analyses that were not needed. Each only where there is something to show.
PageSection check_section(const ReportData& data, const std::vector<Figure>& figures);

// The uncertainty budget as a table with a bar in every cell.

/// Sources down, parameters across: what each source gives to each parameter's standard deviation, the bar as
/// long as its share of it. Empty without a budget.
std::string budget_table(const fit::FitResult& fit);

}  // namespace tribotrack::apps
