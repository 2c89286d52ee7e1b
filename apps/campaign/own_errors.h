// What one run alone is known by, and how well: its gate, the phase at its start, values given for it.
#pragma once

#include "apps/files/campaign/campaign.h"
#include "apps/measuring/measure_run.h"
#include "fit/problem.h"
#include "model/scenario.h"

namespace tribotrack::apps {

/// Adds to the variance of a parameter, and to the covariance of two.
void add_error(fit::OwnErrors& own, model::Parameter parameter, double variance);
void add_error(fit::OwnErrors& own, model::Parameter one, model::Parameter other, double covariance);

/// sd of a parameter; 0 where it has none.
double sd_of(const fit::OwnErrors& own, model::Parameter parameter);

/// The same without these parameters.
fit::OwnErrors without(const fit::OwnErrors& own, const std::vector<model::Parameter>& parameters);

/// phi, dtau and the phase at the start of a scenario, measured where the recording shows them, else as
/// given, with their joint covariance. The marker's phase carries phi where that counts from the camera's own
/// phase: both err alike. A value given with an sd beside a measured one is taken in by its weight.
fit::OwnErrors settle_timing(const CampaignRun& run, RunMeasurement& measured, model::Scenario& scenario);

/// The same for a run measured elsewhere.
fit::OwnErrors timing_as_given(const CampaignRun& run, model::Scenario& scenario);

}  // namespace tribotrack::apps
