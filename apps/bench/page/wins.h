// Where others win: the short tables below the figures.
#pragma once

#include <string>

#include "apps/bench/tables/results.h"

namespace tribotrack::bench {

// HTML with a heading; a sentence where no peer wins.
std::string wins_of_peers(const std::vector<ModelBenchRow>& rows);
std::string wins_of_peers(const std::vector<VisionBenchRow>& rows);
std::string wins_of_peers(const std::vector<FitBenchRow>& rows);

}  // namespace tribotrack::bench
