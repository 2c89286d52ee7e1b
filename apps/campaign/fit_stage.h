// Last: all runs as one least-squares problem, its result, and what stands against using it.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "apps/campaign/compared_runs.h"
#include "apps/campaign/shared_conditions.h"
#include "apps/files/campaign/campaign.h"
#include "apps/files/run_folder.h"
#include "apps/program/context.h"
#include "apps/run/run.h"
#include "apps/text/json.h"
#include "fit/estimate.h"
#include "fit/fit_result.h"
#include "fit/problem.h"

namespace tribotrack::apps {

/// The least-squares problem of all runs that did not fail.
fit::Problem problem_of(const Campaign& campaign, const std::vector<Run>& runs,
                        const SharedConditions& shared);

/// A campaign as far as it got: its runs, what they share as found before the fit, and the fit.
struct FittedCampaign {
  std::vector<Run> runs;
  std::optional<SharedScale> scale;
  SharedConditions conditions;
  fit::FitResult result;
  Json json;  ///< the object of fit.json
};

/// Fits all runs that did not fail, whose scale and conditions have been shared. Throws fit::DataError.
void fit_runs(const Campaign& campaign, FittedCampaign& fitted, const Context& context,
              fit::FitOptions options = {});

/// Writes fit.json and its meta file, which names the campaign and what its runs were read from.
void write_fit(const std::filesystem::path& path, const Campaign& campaign, const FittedCampaign& fitted);

/// The fit's report and warnings on stderr, unless quiet; in any case what stands against using it as it is,
/// the weightiest last. `look_at` names where the user finds more.
void report_fit(const Campaign& campaign, const FittedCampaign& fitted, bool explain,
                const std::string& look_at, Context& context);

/// One line per parameter on stdout: name, estimate, sd, low and high end of the 95 % interval,
/// blank-separated.
std::string parameter_table(const Json& fit);

/// One line per free slide: its own mu1, sd, interval, rim speed over slide speed ("unseen"), chi2, dof.
/// Empty without slides.
std::string slide_table(const Json& fit);

}  // namespace tribotrack::apps
