// What a run of the model is asked for: a scenario file, and values that stand in place of the file's.
#pragma once

#include <list>
#include <optional>
#include <string>
#include <utility>

#include "apps/files/scenario_file.h"
#include "apps/text/csv_table.h"
#include "apps/text/json.h"
#include "model/trajectory.h"

namespace tribotrack::apps {

struct GivenScenario {
  std::string file;  ///< empty: the paper's conditions
  /// As set_scenario_parameter() takes them; in a list, since the command line keeps references.
  std::list<std::pair<std::string, std::optional<double>>> values = {};
  std::string start;  ///< "rest", "circling" or "steady"; empty: the file's
  std::optional<double> samples_per_cycle;
};

/// "--omega-rad-s" of "omega_rad_s".
std::string flag_of(std::string parameter);

/// The file with the values in place, not yet settled: what a sweep varies. Throws InvalidInput and
/// UsageError.
ScenarioFile base_of(const GivenScenario& given);

/// The same, settled and valid. Throws model::InvalidParameter, too.
ScenarioFile scenario_of(const GivenScenario& given);

// One trajectory of the model as users see it: its results, and its table in millimetres.

/// The object `simulate --json` prints.
Json simulation_json(const model::Trajectory& trajectory);

/// time_s, x_mm, y_mm, vx_mm_s, vy_mm_s, all relative to the platform, mu, and state, "slip" or "stick":
/// evenly over the run, its first and last moment included.
Columns columns_of(const model::Trajectory& trajectory, int samples_per_cycle);

/// Before the work: a table may grow beyond any disk. Throws InvalidInput; `name` begins its message.
void require_sensible_table(const std::string& name, const model::Scenario& scenario, int samples_per_cycle);

}  // namespace tribotrack::apps
