// Last: all runs as one least-squares problem.
#pragma once

#include <vector>

#include "apps/campaign/conditions.h"
#include "apps/campaign/shared_conditions.h"
#include "apps/files/campaign/campaign.h"
#include "fit/problem.h"

namespace tribotrack::apps {

/// The least-squares problem of all runs that did not fail.
fit::Problem problem_of(const Campaign& campaign, const std::vector<AnalysedRun>& runs,
                        const SharedConditions& shared);

/// mm/px that the fit parameter `scale` is a factor on: the mean over the runs with a video; 1 where there is
/// none.
double reference_mm_per_px(const std::vector<AnalysedRun>& runs);

}  // namespace tribotrack::apps
