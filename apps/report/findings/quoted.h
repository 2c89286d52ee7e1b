// How the findings are quoted: the same words on the page and in text.
#pragma once

#include <string>

#include "apps/report/data/data.h"

namespace tribotrack::apps {

/// "0.09952 to 0.10073", or "... or ..." where the interval is in pieces.
std::string quoted_interval(const ReportParameter& parameter);

/// "Part 6 × 0.8 mm; 14 runs; filmed 2021-03-04; tribotrack VERSION": what is known of it.
std::string subtitle_of(const ReportData& data);

}  // namespace tribotrack::apps
