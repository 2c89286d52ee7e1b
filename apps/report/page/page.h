// The whole page, from the report's data.
#pragma once

#include <string>

#include "apps/report/data/data.h"

namespace tribotrack::apps {

/// A page that holds everything it needs: style, plotting library, pictures, numbers. It fetches nothing, and
/// its content security policy forbids the browser to. The same data give the same bytes.
std::string page_of(const ReportData& data);

}  // namespace tribotrack::apps
