// The uncertainty budget as a table with a bar in every cell.
#pragma once

#include <string>

#include "apps/report/data/data.h"

namespace tribotrack::apps {

/// Sources down, parameters across: what each source gives to each parameter's standard deviation, the bar as
/// long as its share of it. Empty without a budget.
std::string budget_table(const ReportData& data);

}  // namespace tribotrack::apps
