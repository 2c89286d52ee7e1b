// fit.json: the fit's result for machines, and the table people read.
#pragma once

#include <string>
#include <vector>

#include "apps/campaign/conditions.h"
#include "apps/files/campaign/campaign.h"
#include "apps/text/json.h"
#include "fit/fit_result.h"

namespace tribotrack::apps {

/// The object of fit.json. Parameters stand in campaign units, as their names say.
Json fit_json(const Campaign& campaign, const std::vector<Run>& runs, const fit::FitResult& result);

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
