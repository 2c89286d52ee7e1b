// The report page's parts that are text, tables and pictures: HTML that reads the same without scripts and on
// paper. Each returns an empty string, or a sentence saying so, where there is nothing to show.
#pragma once

#include <string>

#include "apps/report_data.h"

namespace tribotrack::apps {

std::string verdict_section(const ReportData& data);  ///< verdict, warnings
std::string parameter_section(
    const ReportData& data);  ///< values, intervals, correlation, chi-square, next run
std::string picture_section(const ReportData& data);     ///< paths over first frames, fig. 11
std::string run_section(const ReportData& data);         ///< table of runs, failures, notes
std::string plan_section(const ReportData& data);        ///< what was left out and why
std::string provenance_section(const ReportData& data);  ///< version, inputs, configuration

}  // namespace tribotrack::apps
