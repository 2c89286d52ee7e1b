// The report page's section on whether the model is right: HTML that reads the same without scripts and on
// paper.
#pragma once

#include <string>
#include <vector>

#include "apps/page/page.h"
#include "apps/report/data/data.h"

namespace tribotrack::apps {

/// Chi-squared and runs test, residuals, runs and points that contradict the others, the friction models
/// compared, and the analyses that were not needed. Each only where there is something to show.
PageSection check_section(const ReportData& data, const std::vector<Figure>& figures);

// The uncertainty budget as a table with a bar in every cell.

/// Sources down, parameters across: what each source gives to each parameter's standard deviation, the bar as
/// long as its share of it. Empty without a budget.
std::string budget_table(const ReportData& data);

}  // namespace tribotrack::apps
