#include "fit/checks/run_scatter.h"

#include <boost/math/tools/minima.hpp>
#include <cmath>

namespace tribotrack::fit::internal {

std::optional<RunScatter> run_scatter(const Eigen::VectorXd& residuals, const Eigen::VectorXd& by_mu) {
  const Eigen::Index runs = residuals.size() / 2;
  if (runs < 4) return std::nullopt;
  const auto at = [&](double s) {
    RunScatter sum{s, 0, 0};
    for (Eigen::Index i = 0; i < runs; ++i) {
      const auto r = residuals.segment<2>(2 * i), j = by_mu.segment<2>(2 * i);
      const double seen = 1 + s * s * j.squaredNorm(), along = s * j.dot(r);
      sum.fall += along * along / seen - std::log(seen);
      sum.chi2 += r.squaredNorm() - along * along / seen;
    }
    return sum;
  };
  constexpr double kLeast = 1e-5, kMost = 1;
  constexpr int kBits = 20;
  const double best =
      boost::math::tools::brent_find_minima([&](double log_s) { return -at(std::exp(log_s)).fall; },
                                            std::log(kLeast), std::log(kMost), kBits)
          .first;
  const RunScatter found = at(std::exp(best));
  return found.fall > 0 ? std::optional(found) : std::nullopt;
}

Problem with_run_scatter(Problem problem, double relative, double mu1, double mu2) {
  for (SummaryRun& run : problem.summary_runs) {
    run.own.add(model::Parameter::mu1, std::pow(relative * mu1, 2));
    if (!(run.scenario.friction.pulse_width > 0)) continue;
    run.own.add(model::Parameter::mu2, std::pow(relative * mu2, 2));
    run.own.add(model::Parameter::mu1, model::Parameter::mu2, relative * relative * mu1 * mu2);
  }
  return problem;
}

}  // namespace tribotrack::fit::internal
