// The part of the report that comes out of fit.json.
#pragma once

#include "apps/report/data/data.h"
#include "apps/text/json.h"

namespace tribotrack::apps {

/// Everything of `fit` but its runs. What an older file lacks stays absent on the page. Throws WrongContent
/// where a key that every fit.json holds is missing or of the wrong kind.
void read_fit(const Json& fit, ReportData& data);

/// The array `budget`. After the parameters.
void read_budget(const JsonPlace& budget, ReportData& data);

/// The array `conditions`.
void read_conditions(const JsonPlace& conditions, ReportData& data);

}  // namespace tribotrack::apps
