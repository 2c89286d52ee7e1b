// The report page's sections of what the runs gave: direction and velocity, paths, free slides.
#pragma once

#include <string>
#include <vector>

#include "apps/page/page.h"
#include "apps/report/data/data.h"

namespace tribotrack::apps {

/// `shown`: a figure that stands on the first screen already.
PageSection dependence_section(const ReportData& data, const std::vector<Figure>& figures,
                               const std::string& shown);
PageSection picture_section(const ReportData& data);
PageSection slide_section(const ReportData& data, const std::vector<Figure>& figures,
                          const std::string& shown);

// The report page's table of parameters: covariance, profile and bootstrap intervals side by side.

/// One row for each parameter, a column for each kind of interval that any of them has, and beneath it what
/// each is and which covariance is printed.
std::string interval_table(const ReportData& data);

// The report page's section on what to film next.

/// The runs that would narrow the intervals most, with the intervals predicted; empty where none was looked
/// for.
PageSection next_section(const ReportData& data);

}  // namespace tribotrack::apps
