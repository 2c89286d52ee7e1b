// Under what the data agree with a model that they reject as it is described.
#pragma once

#include <optional>
#include <vector>

#include "fit/checks/verdict.h"
#include "fit/stages/estimation.h"

namespace tribotrack::fit::internal {

struct Explained {
  std::vector<ExplainedProblem> list;
  std::optional<Quoted> quoted;
};

/// What explains the residuals, and from where fits under explanations ended the minimum once more, where
/// that is lower.
Explained explain(const Problem& problem, Estimation& fit, const FitOptions& options);

/// Of driven tracks that reject the model: runs that contradict the others, and friction that differs from
/// run to run. Either takes the minimum with it. Bad runs show in displacements, to a usual scatter; how much
/// friction differs the points of each run tell. Nothing where they reject the model still.
Explained explain_tracks(const Problem& problem, const Estimation& fit, const FitOptions& options);

}  // namespace tribotrack::fit::internal
