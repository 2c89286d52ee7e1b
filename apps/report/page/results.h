// The report page's sections of what the runs gave: direction and velocity, paths, free slides.
#pragma once

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

}  // namespace tribotrack::apps
