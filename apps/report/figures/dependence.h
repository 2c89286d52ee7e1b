// alpha and v against phi and dtau: the paper's figures 9a, 9b and 10.
#pragma once

#include <vector>

#include "apps/figures/figure.h"
#include "apps/report/data/data.h"

namespace tribotrack::apps {

std::vector<Figure> dependence_figures(const ReportData& data);

}  // namespace tribotrack::apps
