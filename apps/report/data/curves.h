// The model's curves through the groups of runs.
#pragma once

#include <vector>

#include "apps/report/data/data.h"

namespace tribotrack::apps {

/// Groups data.runs and evaluates the model for each group: the scenario of its first run, at the fitted
/// parameters, with one angle varied.
/// A point that takes more than its share of `most_steps` is left out, and a warning says so: friction next
/// to nothing takes thousands of cycles to settle.
void add_curves(ReportData& data, long most_steps = kMostCurveSteps);

// Which runs belong in one curve of the report's figures, and where to evaluate the model for it.

enum class Over { phi, dtau };

/// A run's phi in one turn, [-0.02, 2 pi - 0.02): a measured 0 that came out as 6.28 stays a 0; or its dtau.
double angle_over(Over over, const ReportRun& run);

/// Groups of runs that share dtau and hold at least two different phi (paper, fig. 9a), ordered by dtau, or
/// with the parts exchanged (figs. 9b and 10); the runs of a group are ordered by the varied one. Runs that
/// failed, slid freely or lack phi, dtau or v are left out. Angles closer than 0.02 rad count as equal.
std::vector<ReportGroup> groups_over(Over over, const std::vector<ReportRun>& runs);

/// Where to evaluate the model for a group's curve, rad: a full turn for phi when the runs span at least half
/// of one, else their range with a tenth to spare; never below 0 or above 2 pi.
std::vector<double> curve_angles(Over over, const ReportGroup& group, const std::vector<ReportRun>& runs,
                                 int count = 121);

// The model's path of a run beside the measured one, and where the part was after each whole cycle.

/// All steps of a path are kept in memory, some hundred MB of these.
inline constexpr long kMostPathSteps = 1'000'000;

/// Fills ReportRun::model_x_mm .. cycle_y_mm from the run's scenario at the fitted values, whose time 0 is
/// the first frame in which the part was measured. Nothing for a free slide, a run without a path, or a path
/// in the camera's frame, which holds the platform's motion too.
/// False where the motion takes more than `most_steps` steps to follow; then there is no model path.
bool add_model_path(ReportRun& run, long most_steps = kMostPathSteps);

/// The platform of a run as drawn: orbit, phase residual over time; nothing where it was not seen to move.
/// The line drawn is the numbers of ReportRun::measured, not a new measurement.
void add_drawings(ReportRun& run);

}  // namespace tribotrack::apps
