// The paths of the part on the platform: the paper's figure 11.
#pragma once

#include <vector>

#include "apps/figures/figure.h"
#include "apps/report/data/data.h"

namespace tribotrack::apps {

std::vector<Figure> trajectory_figures(const ReportData& data);

}  // namespace tribotrack::apps
