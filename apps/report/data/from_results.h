// From the results of a campaign, in memory, to the content of its report.
#pragma once

#include <vector>

#include "apps/campaign/conditions.h"
#include "apps/campaign/fit_stage.h"
#include "apps/files/run_folder.h"
#include "apps/report/data/data.h"
#include "apps/text/json.h"
#include "fit/fit_result.h"

namespace tribotrack::apps {

/// What `run` holds at its end.
struct ReportInput {
  const Campaign& campaign;
  const std::vector<Run>& runs;  ///< at the scale that was used
  const fit::FitResult& fit;
  const SharedFindings& shared;
  const Json& meta;         ///< of fit.json: version, inputs by their hashes, effective configuration
  const RunFolder& folder;  ///< holds the pictures
};

ReportData data_from_results(const ReportInput& input);

}  // namespace tribotrack::apps
