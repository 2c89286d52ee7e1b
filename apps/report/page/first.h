// The first screen of the report: read in ten seconds.
#pragma once

#include <string>
#include <vector>

#include "apps/figures/figure.h"
#include "apps/report/data/data.h"

namespace tribotrack::apps {

/// Verdict, the parameters with the interval to quote, a path over its first frame, and alpha against phi
/// (else the figure that comes nearest to it).
std::string first_screen(const ReportData& data, const std::vector<Figure>& figures);

/// Of the figures the one shown there; empty where there is none.
std::string first_figure(const std::vector<Figure>& figures);

}  // namespace tribotrack::apps
