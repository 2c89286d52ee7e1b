// Measured minus modelled, run by run.
#pragma once

#include <vector>

#include "apps/figures/figure.h"
#include "apps/report/data/data.h"

namespace tribotrack::apps {

std::vector<Figure> residual_figures(const ReportData& data);

}  // namespace tribotrack::apps
