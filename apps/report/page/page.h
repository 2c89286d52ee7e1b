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
/// its content security policy forbids the browser to. The same data give the same bytes.
std::string page_of(const ReportData& data);

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

}  // namespace tribotrack::apps
