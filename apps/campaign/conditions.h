// Then: the conditions under which a run was made, measured where its track shows them, else as given.
#pragma once

#include <exception>
#include <optional>
#include <string>

#include "apps/files/campaign/campaign.h"
#include "apps/files/track_file.h"
#include "apps/run/run.h"

namespace tribotrack::apps {

/// Reads the run's oscilloscope trace and measures the run. `track` is empty for runs measured elsewhere.
/// Throws what measure_run throws, and InvalidInput where the part was lost too often or a condition is
/// neither given nor measured.
Run analyse(const Campaign& campaign, const CampaignRun& run, std::optional<Track> track);

/// Throws InvalidInput, naming run and file, where the run's oscilloscope trace is not there.
void require_trace(const CampaignRun& run);

/// One sentence on why a run failed: the message of any exception, naming the run.
std::string failure_of(const CampaignRun& run, const std::exception& error);

/// Measures it again, after a change of its track's scale.
void measure_again(const Campaign& campaign, Run& analysed);

}  // namespace tribotrack::apps
