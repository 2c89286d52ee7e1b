// Under what the data agree with a model that they reject as it is described.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "fit/stages/estimation.h"

namespace tribotrack::fit::internal {

/// The problem that is quoted, and what it assumes that the one given does not.
struct Quoted {
  Problem problem;
  std::vector<std::string> under;
  std::vector<Explanation> as_good;  ///< others that explain the residuals as well
};

struct Explained {
  std::vector<ExplainedProblem> list;  ///< best first
  std::optional<Quoted> quoted;        ///< the problem under which values are quoted; none: as described
};

/// What explains the residuals. Where a fit under an explanation shows a lower minimum of the fit itself,
/// that descends there and is explained anew.
Explained explain(const Problem& problem, Estimation& fit, const FitOptions& options);

/// Of driven tracks that reject the model: runs that contradict the others, or friction that differs from run
/// to run. Both take the minimum with them. Runs are judged by what they moved, friction being free to differ
/// by 5 %, one by one: F of chi^2 of the best fits with a run and without it. By how much friction differs,
/// each run's own mu1 and mu2 tell; it must be likelier than errors that neighbouring points share. Nothing
/// is quoted where what is left exceeds errors of tracking.
Explained explain_tracks(const Problem& problem, const Estimation& fit, const FitOptions& options);

}  // namespace tribotrack::fit::internal
