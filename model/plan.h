// What a run of the friction model needs, decided from its scenario before anything is integrated.
#pragma once

#include <string>
#include <vector>

#include "model/scenario.h"

namespace tribotrack::model {

/// One piece of machinery: needed or left out, and why.
struct PlanStage {
  std::string name;
  bool on = false;
  std::string reason;           ///< with its figure
  double predicted_saving = 0;  ///< share of the run time leaving it out saves, 0 .. 1
  double error_bound = 0;       ///< m, what leaving it out can add to the end point
};

/// Stick (can the drive fall below friction at all?), pulses (is mu ever switched?), platform drive (A = 0:
/// free slide), tilt, transient. Leaving out what a scene cannot show adds no error: each bound is exactly 0.
std::vector<PlanStage> plan(const Scenario& scenario);

}  // namespace tribotrack::model
