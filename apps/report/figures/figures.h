// The figures of a report.
#pragma once

#include <vector>

#include "apps/figures/figure.h"
#include "apps/report/data/data.h"

namespace tribotrack::apps {

/// Of the campaign: the paper's figures 9a, 9b, 10 and 11 where there are runs for them, v against phi,
/// residuals, free slides, and what the fit says of its parameters.
std::vector<Figure> campaign_figures(const ReportData& data);

/// Of run `index`: position, residual, sd and score over time, the platform's orbit, phase and gate,
/// rotation; those that it has numbers for.
std::vector<Figure> run_figures(const ReportData& data, std::size_t index);

/// "3 phi045": as the runs are called in figures and tables.
std::string run_label(const ReportData& data, std::size_t index);

// alpha and v against phi and dtau: the paper's figures 9a, 9b and 10.

std::vector<Figure> dependence_figures(const ReportData& data);

}  // namespace tribotrack::apps
