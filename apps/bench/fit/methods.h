// What the fit is compared with: one textbook descent, its derivatives exact or by differences through other
// integrators, for displacements and for tracks.
#pragma once

#include <Eigen/Core>
#include <functional>

#include "apps/bench/fit/bench.h"

namespace tribotrack::bench {

/// What a method estimates from one campaign, on the axes mu1, mu2, lag.
struct BenchAnswer {
  Eigen::Vector3d estimate = Eigen::Vector3d::Zero(), sd = estimate, low = estimate, high = estimate;
  bool converged = false;
  double time = 0;  ///< s
  long solves = 0;
};

using BenchMethod = std::function<BenchAnswer(const fit::Problem&)>;

/// Where all descents start.
FitTruth bench_first_guess();

/// estimate() on one thread, as `fit` calls it.
BenchMethod our_fit(bool with_profiles, int starts);

/// A textbook Levenberg-Marquardt with the model's derivatives.
BenchMethod descent_with_exact_derivatives();

enum class BenchSolver { ours, segmented_dormand_prince, paper_recipe };

/// The same with central differences of that relative step through another solver. Tracks are solved from
/// point to point, which costs none of the integrators a step more than its longest one asks for.
BenchMethod descent_by_differences(BenchSolver solver, int max_iterations, double step = 1e-6);

}  // namespace tribotrack::bench
