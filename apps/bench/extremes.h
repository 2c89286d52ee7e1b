// The stiff and extreme scenarios of the friction model, each with a law that must hold there: one list for
// the benchmark's table and for the tests.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <string>
#include <vector>

#include "model/scenario.h"

namespace tribotrack::bench {

/// A statement about the end point of one scenario, and how far it is from holding.
struct ExtremeLaw {
  std::string text;
  double allowed = 0;  ///< of the violation, relative to the path unless the text says otherwise
  std::function<double(const model::Scenario&, const Eigen::Vector2d& end)> violation;
};

struct ExtremeCase {
  std::string name;
  model::Scenario scenario;
  ExtremeLaw law;
};

/// All of them, the ordinary case first. `quick`: 2 cycles each instead of 20 (100 instead of 1e6), the same
/// cases. Where a case exists for a part that always slips (mu1 = 0.1, dtau = pi/2) and for one that sticks
/// in every cycle (mu1 = 0.122, dtau = pi/6), both are there.
std::vector<ExtremeCase> extreme_cases(bool quick);

}  // namespace tribotrack::bench
