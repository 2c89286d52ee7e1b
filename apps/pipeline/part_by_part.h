// A campaign carried out, of one part or of several: each has its own tracks, fit and report.
#pragma once

#include "apps/pipeline/campaign_runner.h"

namespace tribotrack::apps {

/// Of one part. With `plan_only` nothing is done but said.
void run_campaign(const Campaign& campaign, const RunnerOptions& options, bool plan_only, Context& context);

/// Each part into a folder of its name, and DIR/parts.csv with the parameters of all. A part that cannot be
/// fitted is named and left out, with exit code 4; throws InvalidInput where that is all of them.
void run_part_by_part(const Campaign& campaign, const RunnerOptions& options, bool plan_only,
                      Context& context);

}  // namespace tribotrack::apps
