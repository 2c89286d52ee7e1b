// The input of one run: the scaled problem, its pulse edges, start and end.
#pragma once

#include <cmath>

#include "model/equation/edges.h"
#include "model/equation/scaled_problem.h"

namespace tribotrack::model::internal {

/// Everything the solver needs.
template <class T>
struct SolverInput {
  ScaledProblem<T> problem;
  Edges<T> edges;
  bool circling = false;  ///< a pulse already open at the start does not count
  Pair<T> velocity;       ///< at the start
  T start_shift{};        ///< derivatives of the start phase (value 0)
  bool on_orbit =
      false;  ///< `velocity` lies on one motion whatever the start phase: it does not shift with it
  double contraction = HUGE_VAL;  ///< per cycle of that motion
  double cycles = 0, rest = 0;    ///< the run ends `rest` after so many whole cycles
  double tolerance = 1e-16;
  bool dense = false;  ///< keep the pieces
  bool reuse = true;   ///< of repeating cycles
  long max_steps = 0;
};

}  // namespace tribotrack::model::internal
