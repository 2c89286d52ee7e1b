// What would explain the residuals: of everything that the fit takes as exact, what score tests
// (score_tests.h) speak for is refitted, since a large effect is not linear.
#pragma once

#include <string>
#include <vector>

#include "fit/fit_result.h"
#include "fit/minimum/minimise.h"
#include "fit/residuals/residuals.h"

namespace tribotrack::fit::internal {

/// An explanation and the problem in which it holds.
struct ExplainedProblem {
  Explanation found;
  Problem problem;
  Eigen::VectorXd values;  ///< where its refit ended, of the unknowns of the fit it explains; else empty
  double gain = 0;         ///< fall of Akaike's criterion; of slides, with errors of an unknown size
};

/// Best first. `rejected`: those that are near the best are refitted. `best` is the minimum of residuals
/// without excess variance.
std::vector<ExplainedProblem> explanations(const Residuals& residuals, const Minimum& best, bool rejected,
                                           int threads);

/// "a tilt of the platform (1.01(3) rad)", "run 'a', which contradicts the others".
std::string sentence_of(const Explanation& explanation);

/// By how much Akaike's criterion falls.
inline double gain_of(const Explanation& found) {
  return found.chi2_fall - 2 * found.dof;
}

}  // namespace tribotrack::fit::internal
