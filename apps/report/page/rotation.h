// How the parts turned, where the recordings show it.
#pragma once

#include <string>

#include "apps/report/data/data.h"

namespace tribotrack::apps {

/// A small figure of theta over time for each run whose part is seen to turn; empty where none does.
std::string rotation_section(const ReportData& data);

}  // namespace tribotrack::apps
