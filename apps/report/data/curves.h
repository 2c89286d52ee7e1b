// The model's curves through the groups of runs.
#pragma once

#include <vector>

#include "apps/report/data/data.h"
#include "model/scenario.h"

namespace tribotrack::apps {

/// Groups data.runs (groups.h) and evaluates the model for each group: the scenario of its first run with one
/// angle varied. `scenarios`: one per run, at the fitted parameters.
void add_curves(const std::vector<model::Scenario>& scenarios, ReportData& data);

}  // namespace tribotrack::apps
