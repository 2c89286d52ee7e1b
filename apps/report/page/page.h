// The report page's parts that are text and tables: HTML that reads the same without scripts and on paper.
#pragma once

#include <string>
#include <vector>

#include "apps/figures/figure.h"
#include "apps/page/page.h"
#include "apps/report/data/data.h"

namespace tribotrack::apps {

std::string verdict_box(const ReportData& data);  ///< whether to believe it
std::string warning_box(const ReportData& data);
/// Values, intervals, identifiability, correlation, profiles and pairs; the conditions. Empty without a fit.
PageSection parameter_section(const ReportData& data, const std::vector<Figure>& figures);
/// The sources of uncertainty, and how much rests on each run. Empty without a fit.
PageSection budget_section(const ReportData& data, const std::vector<Figure>& figures);
PageSection citing_section(const ReportData& data);
PageSection provenance_section(const ReportData& data);  ///< version, inputs, configuration

// The first screen of the report: read in ten seconds.

/// Verdict, the parameters with the interval to quote, a path over its first frame, and alpha against phi
/// (else the figure that comes nearest to it).
std::string first_screen(const ReportData& data, const std::vector<Figure>& figures);

/// Of the figures the one shown there; empty where there is none.
std::string first_figure(const std::vector<Figure>& figures);

// The sentence of methods that a paper needs, and what to cite.

/// As HTML.
std::string methods_html(const ReportData& data);

// The whole page, from the report's data.

/// A page that holds everything it needs: style, plotting library, pictures, numbers. It fetches nothing, and
/// its content security policy forbids the browser to. The same data give the same bytes.
std::string page_of(const ReportData& data);

}  // namespace tribotrack::apps
