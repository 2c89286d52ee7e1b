// The sentence of methods that a paper needs, and what to cite, as plain text.
#pragma once

#include <string>
#include <vector>

#include "apps/report/data/data.h"

namespace tribotrack::apps {

/// What was done to how many runs, with the program's version; only what was done here.
std::string methods_text(const ReportData& data);

std::vector<std::string> sources_to_cite(const ReportData& data);

}  // namespace tribotrack::apps
