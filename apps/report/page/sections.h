// The report page's parts that are text and tables: HTML that reads the same without scripts and on paper.
#pragma once

#include <string>
#include <vector>

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

}  // namespace tribotrack::apps
