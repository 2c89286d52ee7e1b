// Friction parameters with their intervals from alpha and v that were measured elsewhere. Use: fit
#include <cstdio>
#include <exception>
#include <numbers>
#include <string>

#include "fit/estimate.h"

int main() try {
  using namespace tribotrack;
  constexpr double pi = std::numbers::pi;

  // Direction and mean velocity of five runs; mu1 = 0.1, mu2 = 0.0125 and a lag of 0.2 rad made them.
  struct Row {
    double phi, dtau;  // rad
    double alpha;      // rad, +- 0.01
    double v;          // mm/s, +- 0.02
  };
  constexpr Row table[] = {{0, pi / 3, 5.61, 3.93},
                           {pi / 2, pi / 3, 4.04, 4.03},
                           {pi, pi / 3, 2.49, 4.10},
                           {3 * pi / 2, pi / 3, 0.95, 3.94},
                           {0, pi / 2, 5.48, 6.12}};

  fit::Problem problem;
  problem.free = {fit::FitParameter::mu1, fit::FitParameter::mu2, fit::FitParameter::lag};
  for (const Row& row : table) {
    fit::SummaryRun run;  // its scenario has the paper's conditions: A = 0.28 mm, w = 62.8 rad/s, 20 cycles
    run.name = "run " + std::to_string(problem.summary_runs.size() + 1);
    run.scenario.friction.phase = row.phi;
    run.scenario.friction.pulse_width = row.dtau;
    run.measured = fit::displacement_from_alpha_v({row.alpha, 0.01}, {1e-3 * row.v, 0.02e-3}, 62.8, 20);
    problem.summary_runs.push_back(run);
  }

  const fit::FitResult result = fit::estimate(problem);
  if (!result.usable()) {  // the data do not determine every parameter: the report says which and why
    std::fprintf(stderr, "%s\n", result.full_report().c_str());
    return 1;
  }
  for (const fit::ParameterEstimate& p : result.parameters)
    std::printf("%-14s %.4f +- %.4f, 95 %% from %.4f to %.4f\n", fit::to_string(p.parameter), p.estimate,
                p.sd, p.ci95.low, p.ci95.high);
  std::printf("chi2 %.1f at %d degrees of freedom: %s\n", result.chi2, result.dof,
              fit::to_string(result.agreement));
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
