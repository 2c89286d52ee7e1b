// Then: what all runs of a campaign share, found by fit::pool (fit/conditions.h) and told to people.
#pragma once

#include <string>
#include <vector>

#include "apps/files/campaign/campaign.h"
#include "apps/run/run.h"
#include "apps/text/json.h"
#include "fit/conditions.h"

namespace tribotrack::apps {

struct SharedConditions {
  fit::Conditions pooled;
  std::vector<std::string> warnings;
};

/// What a campaign and a run's recording tell of its conditions.
fit::RunEvidence evidence_of(const Campaign& campaign, const Run& run);

/// Pools what the runs' marks show with what the campaign gives, and puts all runs under the conditions
/// found: Run::scenario, own and amplitude_from_track. Displacements are measured again over the whole cycles
/// of the w used. Throws InvalidInput, naming the likely slip, where given and measured cannot both be.
SharedConditions share_conditions(const Campaign& campaign, std::vector<Run>& runs);

/// The same refusal, of what all of these runs show: for the first of many, before the others are tracked.
void require_no_slips(const Campaign& campaign, const std::vector<Run>& runs);

/// Into fit.json: `conditions`, `taken_as_exact`, `what_not_knowing_costs` and the warnings. The costs are
/// those entries of the budget whose sd nobody gave.
void add_to(Json& fit, const SharedConditions& shared);

/// What they make of the variance of each parameter, a line each: "tilt_x_rad, sd 0.002 (not given): mu1 12
/// %". Empty without any.
std::string costs_text(const Json& fit);

/// For people, a line each. Empty without conditions.
std::string conditions_text(const fit::Conditions& conditions);

}  // namespace tribotrack::apps
