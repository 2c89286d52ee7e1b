// What a run of the model is asked for: a scenario file, and values that stand in place of the file's.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "apps/files/scenario_file.h"

namespace tribotrack::apps {

struct GivenScenario {
  std::string file;                                    ///< empty: the paper's conditions
  std::vector<std::pair<std::string, double>> values;  ///< by their scenario_parameter_names()
  std::string start;                                   ///< "rest", "circling" or "steady"; empty: the file's
  std::optional<double> samples_per_cycle;
};

/// The file with the values in place, not yet settled: what a sweep varies. Throws InvalidInput and
/// UsageError.
ScenarioFile base_of(const GivenScenario& given);

/// The same, settled and valid. Throws model::InvalidParameter, too.
ScenarioFile scenario_of(const GivenScenario& given);

}  // namespace tribotrack::apps
