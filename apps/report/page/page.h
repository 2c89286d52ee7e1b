// The report's page, from the report's data: sections of text and tables, HTML that reads the same without
// scripts and on paper. A section with nothing to show is empty.
#pragma once

#include <string>
#include <vector>

#include "apps/figures/figure.h"
#include "apps/page/page.h"
#include "apps/report/data/data.h"

namespace tribotrack::apps {

/// A page that holds everything it needs: style, plotting library, pictures, numbers. It fetches nothing, and
/// its content security policy forbids the browser to. The same data give the same bytes. `of_campaign`:
/// campaign_figures().
std::string page_of(const ReportData& data, std::vector<Figure> of_campaign);

/// Read in ten seconds: verdict, the parameters with the interval to quote, what they assume, what to do
/// next, a path over its first frame, alpha against phi (else the figure that comes nearest to it), and
/// warnings.
std::string first_screen(const ReportData& data, const std::vector<Figure>& figures);

/// Values, intervals, identifiability, correlation, profiles and pairs; the conditions.
PageSection parameter_section(const ReportData& data, const std::vector<Figure>& figures);
/// The sources of uncertainty, and how much rests on each run.
PageSection budget_section(const ReportData& data, const std::vector<Figure>& figures);
PageSection provenance_section(const ReportData& data);  ///< version, inputs, configuration

// page/results.cpp: what the runs gave. `shown`: a figure that stands on the first screen already.

PageSection dependence_section(const ReportData& data, const std::vector<Figure>& figures,
                               const std::string& shown);
PageSection slide_section(const ReportData& data, const std::vector<Figure>& figures,
                          const std::string& shown);
/// One row for each parameter, a column for each kind of interval that any of them has, and beneath it what
/// each is and which covariance is printed.
std::string interval_table(const ReportData& data);
/// The runs that would narrow the intervals most, with the intervals predicted.
PageSection next_section(const ReportData& data);

// page/runs.cpp: single runs.

PageSection run_section(const ReportData& data);
PageSection audit_section(const ReportData& data);  ///< what the recordings say of their own sds
PageSection plan_section(const ReportData& data);   ///< runs with the same plan in one table
/// `of_runs`: the figures of each run, in their order. Drawn when a reader opens the run.
PageSection detail_section(const ReportData& data, const std::vector<std::vector<Figure>>& of_runs);
/// The paths over the first frames of their recordings, or a sentence that there are none.
PageSection picture_section(const ReportData& data);
/// The one to show first: of the run with the longest path; empty where no recording is at hand.
std::string first_picture(const ReportData& data);

// Figures. Their axes are settled when the page is made.

/// Of the campaign, those it has runs for.
std::vector<Figure> campaign_figures(const ReportData& data);

/// Of run `index`: position, residual, sd and score over time, the platform's orbit and phase,
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
/// What the fit says of its parameters: profiles, pairs, friction against speed, influence of each run.
std::vector<Figure> parameter_figures(const ReportData& data);
/// Free slides: distance along the path against time.
std::vector<Figure> slide_figures(const ReportData& data);

}  // namespace tribotrack::apps
