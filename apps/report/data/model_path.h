// The model's path of a run beside the measured one, and where the part was after each whole cycle.
#pragma once

#include "apps/report/data/data.h"
#include "model/scenario.h"

namespace tribotrack::apps {

/// All steps of a path are kept in memory, some hundred MB of these.
inline constexpr long kMostPathSteps = 1'000'000;

/// Fills ReportRun::model_x_mm .. cycle_y_mm from the run's scenario at the fitted values, whose time 0 is
/// the first frame in which the part was measured. Nothing for a free slide, a run without a path, or a path
/// in the camera's frame, which holds the platform's motion too.
/// False where the motion takes more than `most_steps` steps to follow; then there is no model path.
bool add_model_path(const model::Scenario& scenario, bool in_camera_frame, ReportRun& run,
                    long most_steps = kMostPathSteps);
void note_no_model_path(const ReportRun& run, ReportData& data);

}  // namespace tribotrack::apps
