#include "apps/simulating/given_scenario.h"

#include <algorithm>

#include "apps/program/errors.h"

namespace tribotrack::apps {

ScenarioFile base_of(const GivenScenario& given) {
  const auto is_given = [&](const char* name) {
    return std::ranges::any_of(given.values, [&](const auto& entry) { return entry.first == name; });
  };
  if (is_given("mu2") && is_given("mu1_over_mu2"))
    throw UsageError("--mu2 and --mu1-over-mu2 mean the same; give one of them");
  ScenarioFile file = given.file.empty() ? ScenarioFile{} : read_scenario_file(given.file);
  // amplitude_mm sets both axes, amplitude_y_mm the second: in this order, whatever the order they came in.
  for (const bool of_y : {false, true})
    for (const auto& [name, value] : given.values)
      if ((name == "amplitude_y_mm") == of_y) set_scenario_parameter(file, name, value);
  if (!given.start.empty()) file.scenario.start = parse_start(given.start);
  if (given.samples_per_cycle) {
    if (!(*given.samples_per_cycle >= 1 && *given.samples_per_cycle <= 1e6))
      throw UsageError("--samples-per-cycle must be between 1 and 1000000");
    file.samples_per_cycle = static_cast<int>(*given.samples_per_cycle);
  }
  return file;
}

ScenarioFile scenario_of(const GivenScenario& given) {
  ScenarioFile file = base_of(given);
  file.settle();
  file.scenario.validate();
  return file;
}

}  // namespace tribotrack::apps
