// One recording over time: for who wants to know where a run's numbers come from.
#pragma once

#include <vector>

#include "apps/figures/figure.h"
#include "apps/report/data/data.h"

namespace tribotrack::apps {

std::vector<Figure> figures_of_run(const ReportData& data, std::size_t index);

/// Does the part turn, beyond what its sd explains?
bool part_turns(const ReportRun& run);

// Free slides: distance along the path against time.

std::vector<Figure> slide_figures(const ReportData& data);

// The paths of the part on the platform: the paper's figure 11.

std::vector<Figure> trajectory_figures(const ReportData& data);

}  // namespace tribotrack::apps
