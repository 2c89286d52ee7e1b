// From the folder that `run` has filled to the content of the report.
#pragma once

#include <vector>

#include "apps/files/run_folder.h"
#include "apps/report/data/curves.h"
#include "apps/report/data/data.h"

namespace tribotrack::apps {

/// Reads fit.json, its meta file, the tracks and measurements. Throws InvalidInput naming the file and the
/// key that is missing or wrong. `most_steps`: of the model, for its curves (curves.h).
ReportData collect(const RunFolder& folder, long most_steps = kMostCurveSteps);

/// Sentences that differ in the run they name, and in numbers, as one each: "runs a, b: ..."; in the order of
/// the first of each.
std::vector<std::string> pooled_by_cause(const std::vector<std::string>& sentences,
                                         const std::vector<ReportRun>& runs);

}  // namespace tribotrack::apps
