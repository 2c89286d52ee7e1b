// Free slides: distance along the path against time.
#pragma once

#include <vector>

#include "apps/figures/figure.h"
#include "apps/report/data/data.h"

namespace tribotrack::apps {

std::vector<Figure> slide_figures(const ReportData& data);

}  // namespace tribotrack::apps
