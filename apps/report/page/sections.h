// The report page's parts that are text and tables: HTML that reads the same without scripts and on paper.
#pragma once

#include <string>

#include "apps/report/data/data.h"

namespace tribotrack::apps {

std::string verdict_section(const ReportData& data);  ///< what was found, whether to believe it; warnings
/// Values, intervals, identifiability, correlation, what was taken as known and what an error in it does.
std::string parameter_section(const ReportData& data);
std::string provenance_section(const ReportData& data);  ///< version, inputs, configuration

}  // namespace tribotrack::apps
