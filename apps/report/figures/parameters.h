// What the fit says of its parameters: profiles, pairs, budget, influence of each run.
#pragma once

#include <vector>

#include "apps/figures/figure.h"
#include "apps/report/data/data.h"

namespace tribotrack::apps {

std::vector<Figure> parameter_figures(const ReportData& data);

// Measured minus modelled, run by run.

std::vector<Figure> residual_figures(const ReportData& data);

}  // namespace tribotrack::apps
