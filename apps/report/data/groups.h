// Which runs belong in one curve of the report's figures, and where to evaluate the model for it.
#pragma once

#include <vector>

#include "apps/report/data/data.h"

namespace tribotrack::apps {

/// phi brought into one turn, [-tolerance, 2 pi - tolerance): a measured 0 that came out as 6.28 stays a 0.
double phi_in_one_turn(double phi_rad, double tolerance = 0.02);

/// Groups of runs that share dtau and hold at least two different phi (paper, fig. 9a), ordered by dtau; the
/// runs of a group are ordered by phi. Runs that failed, slid freely or lack phi, dtau or v are left out.
/// Angles closer than `tolerance` rad count as equal (measured angles scatter).
std::vector<ReportGroup> group_over_phi(const std::vector<ReportRun>& runs, double tolerance = 0.02);

/// The same with the parts exchanged: shared phi, at least two different dtau (figs. 9b and 10).
std::vector<ReportGroup> group_over_dtau(const std::vector<ReportRun>& runs, double tolerance = 0.02);

/// Where to evaluate the model for a group's curve, rad: a full turn for phi when the runs span at least half
/// of one, else their range with a tenth to spare; never below 0 or above 2 pi.
std::vector<double> curve_phis(const ReportGroup& group, const std::vector<ReportRun>& runs, int count = 121);
std::vector<double> curve_dtaus(const ReportGroup& group, const std::vector<ReportRun>& runs, int count = 61);

}  // namespace tribotrack::apps
