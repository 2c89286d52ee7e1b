#include "fit/internal/bootstrap.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "fit/internal/parallel.h"
#include "fit/internal/settle.h"
#include "model/displacement_angle.h"

namespace tribotrack::fit::internal {
namespace {

using Random = std::mt19937_64;

class Draw {
 public:
  Draw(const Residuals& residuals, const Minimum& best, double noise, Random& random)
      : residuals_(residuals),
        best_(best),
        noise_(noise),
        random_(random),
        problem_(residuals.unknowns().problem()) {}

  Problem problem() {
    const Eigen::VectorXd values = residuals_.unknowns().values(best_.z);
    for (std::size_t i = 0; i < problem_.summary_runs.size(); ++i) summary(i);
    for (std::size_t i = 0; i < problem_.trajectory_runs.size(); ++i) trajectory(i, values);
    for (auto& [parameter, prior] : problem_.prior)
      if (const auto k = residuals_.unknowns().find(parameter))
        prior.mean = values(*k) + prior.sd * normal_(random_);
    return problem_;
  }

 private:
  Eigen::Vector2d pair() { return {normal_(random_), normal_(random_)}; }

  void summary(std::size_t i) {
    auto& measured = problem_.summary_runs[i].measured;
    const Eigen::LLT<Eigen::Matrix2d> factor(residuals_.covariance(i));
    measured.vector -= residuals_.difference(best_.residuals, i);
    measured.vector += noise_ * Eigen::Vector2d(factor.matrixL() * pair());
  }

  void trajectory(std::size_t i, const Eigen::VectorXd& values) {
    TrajectoryRun& run = problem_.trajectory_runs[i];
    auto& track = run.track;
    if (const Eigen::Index phase = residuals_.unknowns().phase_index(i); phase >= 0)
      run.scenario.start_phase += values(phase) + run.start_phase_sd * normal_(random_);
    const PointResiduals points = residuals_.points(values, i);
    const auto& scatter = residuals_.scatter().trajectories[i];
    // A first-order process with the residuals' correlation time.
    const double time = scatter.correlation_time, rho = (time - 1) / (time + 1);
    Eigen::Vector2d wander = pair();
    for (std::size_t k = 0; k < points.row.size(); ++k) {
      const Eigen::Matrix2d covariance = track.covariance[points.row[k]] + scatter.between_points *
                                                                               scatter.between_points *
                                                                               Eigen::Matrix2d::Identity();
      if (k > 0) wander = rho * wander + std::sqrt(1 - rho * rho) * pair();
      track.position[points.row[k]] +=
          noise_ * Eigen::Vector2d(covariance.llt().matrixL() * wander) - points.residual[k];
    }
    const SlowShapes slow = residuals_.shapes(i, {true, true, true, true});
    for (std::size_t j = 0; j < slow.count(); ++j) {
      const Eigen::Vector2d size = std::sqrt(residuals_.scatter().slow[slow.part[j]]) * pair();
      for (std::size_t k = 0; k < points.row.size(); ++k)
        track.position[points.row[k]] +=
            size * slow.values(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(j));
    }
  }

  const Residuals& residuals_;
  const Minimum& best_;
  double noise_;
  Random& random_;
  Problem problem_;
  std::normal_distribution<double> normal_;
};

/// The point below which `share` of the sorted values lie.
double quantile(const std::vector<double>& sorted, double share) {
  const double place = share * static_cast<double>(sorted.size() - 1);
  const auto k = static_cast<std::size_t>(place);
  if (k + 1 >= sorted.size()) return sorted.back();
  return sorted[k] + (place - static_cast<double>(k)) * (sorted[k + 1] - sorted[k]);
}

}  // namespace

Bootstrap bootstrap(const Residuals& residuals, const Minimum& best, bool scatter_estimated,
                    const FitOptions& options) {
  const Unknowns& unknowns = residuals.unknowns();
  const double dof = std::max(1.0, residuals.degrees_of_freedom());
  const auto count = static_cast<std::size_t>(options.bootstrap);
  std::vector<Eigen::VectorXd> estimates(count);
  parallel_for(count, options.threads, [&](std::size_t k) {
    std::seed_seq seed{options.bootstrap_seed, static_cast<unsigned>(k)};
    Random random(seed);
    const double noise =
        scatter_estimated ? std::sqrt(dof / std::chi_squared_distribution<double>(dof)(random)) : 1;
    const Problem drawn = Draw(residuals, best, noise, random).problem();
    const Unknowns own(drawn);
    Residuals refit(drawn, own);
    refit.set_scatter(residuals.scatter());
    refit.set_tolerance(residuals.tolerance_for(0.03, 1e-5));
    if (refit.size() != residuals.size()) return;  // a free slide whose strike moved by a frame
    Minimum minimum = minimise(refit, best.z, {.held = {}, .decrement = 1e-4});
    if (options.loss != Loss::squares && std::isfinite(minimum.chi2))
      settle(refit, minimum, {.loss = options.loss});
    if (minimum.converged) estimates[k] = own.values(minimum.z);
  });

  Bootstrap result;
  std::erase_if(estimates, [](const Eigen::VectorXd& values) { return values.size() == 0; });
  result.converged = static_cast<int>(estimates.size());
  const Eigen::VectorXd centre = unknowns.values(best.z);
  for (Eigen::Index i = 0; i < unknowns.reported(); ++i) {
    std::vector<double> sorted;
    for (const Eigen::VectorXd& values : estimates)
      sorted.push_back(unknowns.parameter(i) == FitParameter::lag
                           ? centre(i) + model::wrap_angle(values(i) - centre(i))
                           : values(i));
    std::sort(sorted.begin(), sorted.end());
    const double nan = std::numeric_limits<double>::quiet_NaN();
    result.ci95.push_back(sorted.size() < 20 ? Interval{nan, nan}
                                             : Interval{quantile(sorted, 0.025), quantile(sorted, 0.975)});
  }
  return result;
}

}  // namespace tribotrack::fit::internal
