// The report: one self-contained HTML page.
#pragma once

#include <string>

#include "apps/report/data/data.h"

namespace tribotrack::apps {

/// Turns the data into a page that holds everything it needs: style, plotting library, pictures, numbers. It
/// fetches nothing, and its content security policy forbids the browser to. The same data give the same
/// bytes.
///
/// A caller's order of work:
///   data.runs = ...;                                    // measurements of every run
///   data.over_phi = group_over_phi(data.runs);          // report_groups.h
///   for (ReportGroup& group : data.over_phi) {
///     group.curve_x_rad = curve_phis(group, data.runs);
///     ...                                               // the model's alpha and v at each of them
///   }
///   write(render_report(data));
std::string render_report(const ReportData& data);

}  // namespace tribotrack::apps
