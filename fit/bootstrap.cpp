#include "fit/internal/bootstrap.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <random>

#include "fit/internal/curved_residuals.h"
#include "fit/internal/parallel.h"
#include "fit/internal/settle.h"
#include "model/batch.h"
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

/// Refits to data drawn from the fitted model, from its minimum.
class Refits {
 public:
  Refits(const Residuals& residuals, const Minimum& best, bool scatter_estimated, const FitOptions& options)
      : residuals_(residuals),
        best_(best),
        scatter_estimated_(scatter_estimated),
        options_(options),
        problem_(residuals.unknowns().problem()),
        fine_(residuals) {
    fine_.set_tolerance(residuals.tolerance_for(kFine, 1e-6));
  }

  /// Values of all unknowns, a draw each; empty where the refit did not converge.
  std::vector<Eigen::VectorXd> all() {
    const auto count = static_cast<std::size_t>(options_.bootstrap);
    std::vector<Eigen::VectorXd> estimates(count), starts(count, best_.z);
    if (options_.loss == Loss::squares && residuals_.scatter().along == residuals_.scatter().across &&
        worth_a_second_order(count))
      curved_ = CurvedResiduals::about(fine_, best_, options_.threads);
    if (curved_ && problem_.trajectory_runs.empty()) side_by_side(estimates, starts);
    parallel_for(count, options_.threads, [&](std::size_t k) {
      if (estimates[k].size() > 0) return;
      const Problem problem = drawn(k);
      const Unknowns own(problem);
      Residuals refit(problem, own);
      refit.set_scatter(residuals_.scatter());
      if (refit.size() != residuals_.size()) return;  // a free slide whose strike moved by a frame
      Eigen::VectorXd& start = starts[k];
      if (curved_ && !problem_.trajectory_runs.empty()) {
        start = same_motion(problem, own);
        if (refined(refit, start, estimates[k])) return;
      }
      refit.set_tolerance(residuals_.tolerance_for(0.03, 1e-5));
      Minimum minimum = minimise(refit, start, {.held = {}, .decrement = 1e-4});
      if (options_.loss != Loss::squares && std::isfinite(minimum.chi2))
        settle(refit, minimum, {.loss = options_.loss});
      if (minimum.converged) estimates[k] = own.values(minimum.z);
    });
    return estimates;
  }

 private:
  static constexpr double kFine = 1e-3;  ///< share of the sigma that the integrator may err by
  /// Misfit of the second order at its minimum, in sigma for each standard deviation gone: the derivatives
  /// there are off by about three times as much.
  static constexpr double kMisfit = 0.006;
  static constexpr double kDecrement = 0.01;  ///< of the last step: a tenth of a standard deviation

  /// 2 n Jacobians are to be fewer than what the draws save, and to fit into memory.
  bool worth_a_second_order(std::size_t count) const {
    const auto n = static_cast<std::size_t>(residuals_.unknowns().size());
    return n < count && static_cast<std::size_t>(residuals_.size()) * n * n < 30'000'000;
  }

  Problem drawn(std::size_t k) const {
    std::seed_seq seed{options_.bootstrap_seed, static_cast<unsigned>(k)};
    Random random(seed);
    const double dof = std::max(1.0, residuals_.degrees_of_freedom());
    const double noise =
        scatter_estimated_ ? std::sqrt(dof / std::chi_squared_distribution<double>(dof)(random)) : 1;
    return Draw(residuals_, best_, noise, random).problem();
  }

  /// Where `own`'s motions are those of the best fit: a drawn run's phase holds what it was shifted by.
  Eigen::VectorXd same_motion(const Problem& problem, const Unknowns& own) const {
    Eigen::VectorXd values = residuals_.unknowns().values(best_.z);
    for (std::size_t i = 0; i < problem.trajectory_runs.size(); ++i)
      if (const Eigen::Index phase = own.phase_index(i); phase >= 0)
        values(phase) -= problem.trajectory_runs[i].scenario.start_phase -
                         problem_.trajectory_runs[i].scenario.start_phase;
    return own.z(values);
  }

  /// The second order's minimum `t` and the step from there that exact residuals ask for.
  std::optional<Eigen::VectorXd> corrected(const Eigen::VectorXd& r0, const Eigen::VectorXd& t,
                                           const Eigen::VectorXd& exact) const {
    const double misfit = (exact - curved_->at(r0, t)).norm();
    const Eigen::VectorXd step = curved_->step(exact, t);
    if (!(misfit < kMisfit * std::max(1.0, t.norm())) || !(step.squaredNorm() < kDecrement))
      return std::nullopt;
    return t + step;
  }

  /// One refit of tracks by the second order; false where a descent is to do it.
  bool refined(Residuals& refit, const Eigen::VectorXd& start, Eigen::VectorXd& estimate) const {
    refit.set_tolerance(residuals_.tolerance_for(kFine, 1e-6));
    const Unknowns& own = refit.unknowns();
    const Eigen::VectorXd by = start - best_.z;
    Eigen::VectorXd r0, exact;
    if (!refit.evaluate(own.values(start), r0, nullptr)) return false;
    const auto t = curved_->minimum(r0);
    if (!t || !refit.evaluate(own.values(curved_->z(*t) + by), exact, nullptr)) return false;
    const auto end = corrected(r0, *t, exact);
    if (end) estimate = own.values(curved_->z(*end) + by);
    return end.has_value();
  }

  /// Displacements: of all draws together, each solved once, at the second order's minimum.
  void side_by_side(std::vector<Eigen::VectorXd>& estimates, std::vector<Eigen::VectorXd>& starts) const {
    const Unknowns& unknowns = residuals_.unknowns();
    const std::size_t runs = problem_.summary_runs.size();
    const auto rows = 2 * static_cast<Eigen::Index>(runs), priors = residuals_.size() - rows;
    const Eigen::VectorXd centre = unknowns.values(best_.z);
    struct Refit {
      Eigen::VectorXd r0, t, values;
      std::vector<Eigen::Vector2d> measured;
    };
    std::vector<Refit> refits(estimates.size());
    std::vector<Eigen::LLT<Eigen::Matrix2d>> sigma;
    std::vector<Eigen::Vector2d> modelled;
    for (std::size_t i = 0; i < runs; ++i) {
      sigma.emplace_back(residuals_.covariance(i));
      modelled.push_back(problem_.summary_runs[i].measured.vector -
                         residuals_.difference(best_.residuals, i));
    }
    parallel_for(refits.size(), options_.threads, [&](std::size_t k) {
      const Problem problem = drawn(k);
      Refit& refit = refits[k];
      refit.r0 = best_.residuals;
      for (std::size_t i = 0; i < runs; ++i) {
        refit.measured.push_back(problem.summary_runs[i].measured.vector);
        refit.r0.segment<2>(2 * static_cast<Eigen::Index>(i)) =
            sigma[i].matrixL().solve(refit.measured[i] - modelled[i]);
      }
      for (const auto& [parameter, prior] : problem.prior)
        if (const auto u = unknowns.find(parameter))
          refit.r0.tail(priors) -=
              best_.jacobian.col(*u).tail(priors) * (prior.mean - problem_.prior.at(parameter).mean);
      if (const auto t = curved_->minimum(refit.r0)) {
        refit.t = *t;
        refit.values = unknowns.values(curved_->z(*t));
      }
    });
    std::vector<std::size_t> order;  // of those that are solved
    for (std::size_t k = 0; k < refits.size(); ++k)
      if (refits[k].t.size() > 0) order.push_back(k);
    model::BatchOptions batch;
    batch.threads = options_.threads;
    batch.tolerance = residuals_.tolerance_for(kFine, 1e-6);
    const auto run_at = [&](std::size_t index) {
      return unknowns.apply_summary(refits[order[index / runs]].values, problem_.summary_runs[index % runs],
                                    false);
    };
    const model::BatchOutcome outcome = model::solve_batch(
        order.size() * runs, [&](std::size_t index) { return run_at(index).scenario; }, batch);
    for (std::size_t k = 0; k < order.size(); ++k) {
      const Refit& refit = refits[order[k]];
      Eigen::VectorXd exact = refit.r0;
      bool solved = true;
      for (std::size_t i = 0; i < runs; ++i) {
        const model::BatchEnd& end = outcome.ends[k * runs + i];
        solved = solved && end.status == model::BatchStatus::done;
        const auto applied = run_at(k * runs + i);
        exact.segment<2>(2 * static_cast<Eigen::Index>(i)) =
            sigma[i].matrixL().solve(refit.measured[i] - end.position * (applied.stretch / applied.scale));
      }
      exact.tail(priors) += best_.jacobian.bottomRows(priors) * (refit.values - centre);
      const auto t = solved ? corrected(refit.r0, refit.t, exact) : std::nullopt;
      if (t)
        estimates[order[k]] = unknowns.values(curved_->z(*t));
      else
        starts[order[k]] = curved_->z(refit.t);
    }
  }

  const Residuals& residuals_;
  const Minimum& best_;
  bool scatter_estimated_;
  const FitOptions& options_;
  const Problem& problem_;
  Residuals fine_;
  std::optional<CurvedResiduals> curved_;
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
  std::vector<Eigen::VectorXd> estimates = Refits(residuals, best, scatter_estimated, options).all();
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
