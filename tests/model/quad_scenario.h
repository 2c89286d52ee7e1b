// A scenario's parameters in quadruple precision: so that differences may be taken in them.
#pragma once

#include <array>

#include "model/quad_math.h"
#include "model/scenario.h"

namespace tribotrack::model::reference {

/// All parameters of a Scenario, in quadruple precision.
struct QuadScenario {
  std::array<quad, 15> value;  ///< by Parameter
  quad duration, cycles;
  explicit QuadScenario(const Scenario& s) : duration(s.duration), cycles(s.cycles) {
    for (int p = 0; p < 15; ++p) value[p] = s.get(static_cast<Parameter>(p));
  }
  quad& operator[](Parameter p) { return value[static_cast<int>(p)]; }
  quad operator[](Parameter p) const { return value[static_cast<int>(p)]; }
};

}  // namespace tribotrack::model::reference
