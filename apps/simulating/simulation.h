// One trajectory of the model as users see it: its results, and its table in millimetres.
#pragma once

#include <functional>
#include <string>

#include "apps/text/json.h"
#include "model/trajectory.h"

namespace tribotrack::apps {

/// The object `simulate --json` prints.
Json simulation_json(const model::Trajectory& trajectory);

/// A row of the table.
struct SimulatedRow {
  double time_s = 0;
  double x_mm = 0, y_mm = 0, vx_mm_s = 0, vy_mm_s = 0;  ///< relative to the platform
  double mu = 0;
  const char* state = "slip";  ///< or "stick"
};

/// Visits the rows in the order of time: evenly over the run, its first and last moment included.
void for_each_row(const model::Trajectory& trajectory, int samples_per_cycle,
                  const std::function<void(const SimulatedRow&)>& visit);

/// Before the work: a table may grow beyond any disk. Throws InvalidInput; `name` begins its message.
void require_sensible_table(const std::string& name, const model::Scenario& scenario, int samples_per_cycle);

}  // namespace tribotrack::apps
