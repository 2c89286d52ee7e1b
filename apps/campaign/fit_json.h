// fit.json: the fit's result for machines, and the table people read.
#pragma once

#include <string>
#include <vector>

#include "apps/campaign/conditions.h"
#include "apps/files/campaign/campaign.h"
#include "apps/text/json.h"
#include "fit/estimate.h"

namespace tribotrack::apps {

/// The object of fit.json. Parameters stand in campaign units, as their names say.
Json fit_json(const Campaign& campaign, const std::vector<Run>& runs, const fit::FitResult& result);

/// Its array `budget`.
Json budget_json(const fit::FitResult& result, double mm_per_px);

/// Factor from SI to the unit a parameter has in campaigns and fit.json; `scale` counts in mm/px.
double campaign_unit_per_si(fit::FitParameter parameter, double mm_per_px);

/// Whether what a lossy coder may do to the platform's motion exceeds the interval of a parameter without it.
bool coder_exceeds_interval(const fit::FitResult& result);

/// What phi counts from, and with it the effect of a turned camera on the lag. Empty without pulses.
std::string phase_reference(const Campaign& campaign, const std::vector<Run>& runs);

/// The result of a free slide, as one sentence.
std::string slide_sentence(const fit::RunResult& run);

/// All that fit.json warns of: from the fit, the campaign file and each run's measurement.
std::vector<std::string> warnings_of(const Campaign& campaign, const std::vector<Run>& runs,
                                     const fit::FitResult& result);

/// One line per parameter on stdout: name, estimate, sd, low and high end of the 95 % interval,
/// blank-separated.
std::string parameter_table(const Json& fit);

/// One line per free slide: its own mu1, sd, interval, rim speed over slide speed ("unseen"), chi2, dof.
/// Empty without slides.
std::string slide_table(const Json& fit);

/// Why a fit is unusable, and what to do: one sentence for each thing the data do not determine, and the run
/// to film next. Empty for a usable one.
std::vector<std::string> remedies(const fit::FitResult& result);

}  // namespace tribotrack::apps
