// The figures of a report.
#pragma once

#include <string>
#include <vector>

#include "apps/figures/figure.h"
#include "apps/report/data/data.h"

namespace tribotrack::apps {

/// Of the campaign, those it has runs for, axes settled.
std::vector<Figure> campaign_figures(const ReportData& data);

/// Of run `index`: position, residual, sd and score over time, the platform's orbit, phase and gate,
/// rotation; those that it has numbers for.
std::vector<Figure> run_figures(const ReportData& data, std::size_t index);

/// "3 phi045": as the runs are called in figures and tables.
std::string run_label(const ReportData& data, std::size_t index);

// Parts of campaign_figures().

/// alpha and v against phi and dtau: the paper's figures 9a, 9b and 10.
std::vector<Figure> dependence_figures(const ReportData& data);
/// The paths of the part on the platform: the paper's figure 11.
std::vector<Figure> trajectory_figures(const ReportData& data);
/// Measured minus modelled, run by run.
std::vector<Figure> residual_figures(const ReportData& data);
/// What the fit says of its parameters: profiles, pairs, influence of each run.
std::vector<Figure> parameter_figures(const ReportData& data);
/// Free slides: distance along the path against time.
std::vector<Figure> slide_figures(const ReportData& data);

}  // namespace tribotrack::apps
