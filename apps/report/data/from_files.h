// From the folder that `run` leaves to the content of its report.
#pragma once

#include "apps/files/run_folder.h"
#include "apps/report/data/curves.h"
#include "apps/report/data/data.h"

namespace tribotrack::apps {

/// Reads fit.json, its meta file, the tracks and measurements. Gives what data_from_results gave in the
/// process that wrote them, bit for bit. Throws InvalidInput naming the file and the key that is missing or
/// wrong. `most_steps`: of the model, for its curves (curves.h).
ReportData data_from_files(const RunFolder& folder, long most_steps = kMostCurveSteps);

}  // namespace tribotrack::apps
