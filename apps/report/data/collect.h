// From the results of `run`, or from the folder that it left, to the content of the report: one way for both,
// by the objects of fit.json and of its meta file.
#pragma once

#include <vector>

#include "apps/files/run_folder.h"
#include "apps/report/data/curves.h"
#include "apps/report/data/data.h"
#include "apps/run/run.h"
#include "apps/text/json.h"

namespace tribotrack::apps {

/// What `run` holds at its end.
struct ReportInput {
  const Json& fit;   ///< the object of fit.json
  const Json& meta;  ///< of its meta file: version, inputs by their hashes, effective configuration
  const std::vector<Run>& runs;  ///< at the scale that was used
  const RunFolder& folder;       ///< holds the pictures
};

ReportData collect(const ReportInput& input);

/// Reads fit.json, its meta file, the tracks and measurements: the same as in the process that wrote them,
/// bit for bit. Throws InvalidInput naming the file and the key that is missing or wrong. `most_steps`: of
/// the model, for its curves (curves.h).
ReportData collect(const RunFolder& folder, long most_steps = kMostCurveSteps);

/// Sentences that differ in the run they name, and in numbers, as one each: "runs a, b: ..."; in the order of
/// the first of each.
std::vector<std::string> pooled_by_cause(const std::vector<std::string>& sentences,
                                         const std::vector<ReportRun>& runs);

/// Title, version, inputs, effective configuration and what it gave, from the meta file. After data.fit and
/// data.conditions. Throws InvalidInput, naming `file`.
void add_provenance(const Json& meta, const std::filesystem::path& file, ReportData& data);

}  // namespace tribotrack::apps
