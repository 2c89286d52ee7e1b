#include "fit/checks/run_scatter.h"

#include <Eigen/LU>
#include <boost/math/tools/minima.hpp>
#include <cmath>
#include <vector>

#include "fit/tools/dense.h"

namespace tribotrack::fit::internal {
namespace {

/// Share to which displacements are linear where friction differs by 1 to 3 %: nine in ten of stepped motions
/// of 14 runs are, half of them to a hundredth or two.
constexpr double kBent = 0.1;

/// The likeliest s of residuals with the covariances I + s^2 shape.
RunScatter likeliest(const Eigen::VectorXd& residuals, const std::vector<Eigen::Matrix2d>& shapes,
                     double least, double most) {
  const auto of = [&](double s) {
    RunScatter sum{.relative = s};
    for (std::size_t i = 0; i < shapes.size(); ++i) {
      const Eigen::Vector2d r = residuals.segment<2>(2 * static_cast<Eigen::Index>(i));
      const Eigen::Matrix2d seen = Eigen::Matrix2d::Identity() + s * s * shapes[i];
      const double left = r.dot(Factor2(seen).solved(r));
      sum.fall += r.squaredNorm() - left - std::log(seen.determinant());
      sum.chi2 += left;
    }
    return sum;
  };
  constexpr int kBits = 20;
  const auto rise = [&](double log_s) { return -of(std::exp(log_s)).fall; };
  return of(
      std::exp(boost::math::tools::brent_find_minima(rise, std::log(least), std::log(most), kBits).first));
}

}  // namespace

std::optional<RunScatter> run_scatter(const Residuals& residuals, const Eigen::VectorXd& values,
                                      const Linearised& at) {
  const Unknowns& unknowns = residuals.unknowns();
  const auto runs = unknowns.problem().summary_runs.size();
  if (runs < 4) return std::nullopt;
  const RowGroup& rows = at.groups.front();
  std::vector<Eigen::Matrix2d> apart, together, anyhow;
  for (std::size_t k = 0; k < runs; ++k) {
    Eigen::Matrix2d g = Eigen::Matrix2d::Zero();
    for (const FitParameter mu : {FitParameter::mu1, FitParameter::mu2})
      if (const auto i = unknowns.find(mu))
        g.col(mu == FitParameter::mu2) =
            unknowns.value_of(mu, values) * rows.shared.col(*i).segment<2>(2 * static_cast<Eigen::Index>(k));
    const auto shape = [](const auto& moves) -> Eigen::Matrix2d {
      return moves * moves.transpose() +
             0.5 * kBent * kBent * moves.squaredNorm() * Eigen::Matrix2d::Identity();
    };
    apart.push_back(shape(g));
    together.push_back(shape(Eigen::Vector2d(g.rowwise().sum())));
    const Eigen::Matrix2d whitening = Factor2(residuals.covariance(k)).inverse_lower();
    anyhow.push_back(whitening * whitening.transpose());
  }
  const Eigen::VectorXd data = rows.residuals.head(2 * static_cast<Eigen::Index>(runs));
  RunScatter found = likeliest(data, apart, 1e-5, 1), both = likeliest(data, together, 1e-5, 1);
  both.together = true;
  if (both.fall > found.fall) found = both;
  found.beyond_any = found.fall - likeliest(data, anyhow, 1e-9, 1).fall;
  found.chi2 += at.chi2() - data.squaredNorm();
  return found.fall > 0 ? std::optional(found) : std::nullopt;
}

Explanation scatter_of(double per_cent, std::size_t numbers) {
  Explanation found;
  found.name = "run_scatter";
  found.unit = "%";
  found.size = per_cent;
  found.size_sd = per_cent / std::sqrt(2.0 * static_cast<double>(numbers));
  return found;
}

Problem with_run_scatter(Problem problem, double relative, bool together, double mu1, double mu2) {
  const auto add = [&](const model::Friction& friction, OwnErrors& own) {
    own.add(model::Parameter::mu1, std::pow(relative * mu1, 2));
    if (!(friction.pulse_width > 0)) return;
    own.add(model::Parameter::mu2, std::pow(relative * mu2, 2));
    if (together) own.add(model::Parameter::mu1, model::Parameter::mu2, relative * relative * mu1 * mu2);
  };
  for (SummaryRun& run : problem.summary_runs) {
    add(run.scenario.friction, run.own);
    run.own.bent = kBent;
  }
  for (TrajectoryRun& run : problem.trajectory_runs)
    if (!run.free_slide) add(run.scenario.friction, run.own);
  return problem;
}

}  // namespace tribotrack::fit::internal
