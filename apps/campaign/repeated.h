// A recording that stands twice in a campaign tells nothing twice.
#pragma once

#include <string>
#include <vector>

#include "apps/campaign/conditions.h"

namespace tribotrack::apps {

/// Runs whose tracks are the same to the last bit as an earlier one's: each gets AnalysedRun::repeats. Throws
/// InvalidInput where they are given with different phi or dtau, of which one is wrong.
void set_aside_repeated(std::vector<AnalysedRun>& runs);

/// 'run "b" is the recording of run "a" once more: it is counted once', one for each.
std::vector<std::string> repeated_text(const std::vector<AnalysedRun>& runs);

}  // namespace tribotrack::apps
