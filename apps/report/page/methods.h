// The sentence of methods that a paper needs, and what to cite.
#pragma once

#include <string>

#include "apps/report/data/data.h"

namespace tribotrack::apps {

/// As HTML.
std::string methods_html(const ReportData& data);

}  // namespace tribotrack::apps
