// The model's curves through the groups of runs.
#pragma once

#include <vector>

#include "apps/report/data/data.h"
#include "model/scenario.h"

namespace tribotrack::apps {

/// How many steps of the model (IntegrationSummary::steps) the curves of a report may take together: seconds.
inline constexpr long kMostCurveSteps = 5'000'000;

/// Groups data.runs (groups.h) and evaluates the model for each group: the scenario of its first run with one
/// angle varied. `scenarios`: one per run, at the fitted parameters.
/// A point that takes more than its share of `most_steps` is left out, and a warning says so: friction next
/// to nothing takes thousands of cycles to settle.
void add_curves(const std::vector<model::Scenario>& scenarios, ReportData& data,
                long most_steps = kMostCurveSteps);

}  // namespace tribotrack::apps
