// Then: the conditions under which a run was made, measured where its track shows them, else as given.
#pragma once

#include <exception>
#include <string>

#include "apps/files/campaign/campaign.h"
#include "apps/run/run.h"

namespace tribotrack::apps {

/// Measures a run with its track: reads its oscilloscope trace, if any, and fills in the rest. Throws what
/// measure_run throws, and InvalidInput where the part was lost too often or a condition is neither given nor
/// measured.
void measure(const Campaign& campaign, Run& run);

/// Throws InvalidInput, naming run and file, where the run's oscilloscope trace is not there.
void require_trace(const CampaignRun& run);

/// One sentence on why a run failed: the message of any exception, naming the run.
std::string failure_of(const CampaignRun& run, const std::exception& error);

/// Measures it again, after a change of its track's scale.
void measure_again(const Campaign& campaign, Run& run);

}  // namespace tribotrack::apps
