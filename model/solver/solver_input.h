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

/// The same input without its derivatives by the parameters, and room for others.
template <class U, class T>
SolverInput<U> lifted(const SolverInput<T>& in) {
  const auto number = [](const T& a) { return U(value(a)); };
  const auto pair = [&](const Pair<T>& a) { return Pair<U>{number(a.x), number(a.y)}; };
  SolverInput<U> out;
  const ScaledProblem<T>& p = in.problem;
  out.problem = {{pair(p.drive.constant), pair(p.drive.p), pair(p.drive.q)},
                 number(p.kappa_nominal),
                 number(p.kappa_reduced),
                 p.velocity_unit};
  out.edges.count = in.edges.count;
  out.edges.open_at_start = in.edges.open_at_start;
  for (int i = 0; i < in.edges.count; ++i)
    out.edges.edge[i] = {in.edges.edge[i].s, U{}, in.edges.edge[i].opens};
  out.circling = in.circling;
  out.velocity = pair(in.velocity);
  out.cycles = in.cycles;
  out.rest = in.rest;
  out.tolerance = in.tolerance;
  out.max_steps = in.max_steps;
  return out;
}

}  // namespace tribotrack::model::internal
