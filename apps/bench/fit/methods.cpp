#include "apps/bench/fit/methods.h"

#include <Eigen/Dense>
#include <cmath>

#include "apps/bench/fit/plain_descent.h"
#include "apps/bench/peers/baselines.h"
#include "fit/estimate.h"
#include "fit/residuals/end_point.h"
#include "model/trajectory.h"

namespace tribotrack::bench {

using namespace fit;
using namespace fit::internal;

namespace {

using Eigen::Matrix2Xd;
using Eigen::Vector2d;
using Eigen::Vector3d;

model::Scenario scenario_at(const model::Scenario& base, const Vector3d& z) {
  model::Scenario s = base;
  s.friction.nominal = std::exp(z(0));
  s.friction.reduced = std::exp(z(1));
  s.friction.lag = z(2);
  return s;
}

/// From the track's first point.
std::vector<double> times_of(const TrajectoryRun& run) {
  std::vector<double> times;
  for (const double time : run.track.time) times.push_back(time - run.track.time.front());
  return times;
}

/// Positions at increasing times, the first 0, by an integrator that knows end points only.
Matrix2Xd from_point_to_point(const model::Scenario& scenario, const std::vector<double>& times,
                              const DormandPrinceOptions& options) {
  Matrix2Xd positions = Matrix2Xd::Zero(2, static_cast<Eigen::Index>(times.size()));
  model::Scenario piece = scenario;
  for (std::size_t i = 1; i < times.size(); ++i) {
    piece.start_phase = scenario.start_phase + scenario.drive.angular_frequency * times[i - 1];
    piece.duration = times[i] - times[i - 1];
    const PeerResult end = dormand_prince(piece, options);
    piece.initial_velocity = end.velocity;
    const auto k = static_cast<Eigen::Index>(i);
    positions.col(k) = positions.col(k - 1) + end.position;
  }
  return positions;
}

DormandPrinceOptions options_of(BenchSolver solver, const model::Scenario& scenario) {
  return solver == BenchSolver::paper_recipe ? paper_recipe() : segmented_dormand_prince(scenario, 1e-8);
}

Vector2d end_by(BenchSolver solver, const model::Scenario& scenario) {
  if (solver == BenchSolver::ours) return end_point(scenario, {}, 1e-16).position;
  return dormand_prince(scenario, options_of(solver, scenario)).position;
}

Matrix2Xd track_by(BenchSolver solver, model::Scenario scenario, const std::vector<double>& times) {
  if (solver != BenchSolver::ours) return from_point_to_point(scenario, times, options_of(solver, scenario));
  scenario.duration = times.back();
  const model::Trajectory trajectory = model::integrate(scenario);
  Matrix2Xd positions(2, static_cast<Eigen::Index>(times.size()));
  for (std::size_t i = 0; i < times.size(); ++i)
    positions.col(static_cast<Eigen::Index>(i)) =
        trajectory.at(std::min(times[i], trajectory.end_time())).position;
  return positions;
}

/// Rows of a track: less their weighted means, which the unknown start point takes, divided by sigma. All
/// points of a simulated track share one.
Eigen::MatrixXd whitened(const TrajectoryRun& run, Eigen::MatrixXd by_point) {
  const double sigma = std::sqrt(run.track.covariance.front()(0, 0));
  for (auto column : by_point.colwise()) {
    Eigen::Map<Matrix2Xd> points(column.data(), 2, column.size() / 2);
    points.colwise() -= points.rowwise().mean().eval();
  }
  return by_point / sigma;
}

Eigen::Index rows_of(const Problem& problem) {
  Eigen::Index rows = 2 * static_cast<Eigen::Index>(problem.summary_runs.size());
  for (const auto& run : problem.trajectory_runs)
    rows += 2 * static_cast<Eigen::Index>(run.track.time.size());
  return rows;
}

Eigen::VectorXd residuals_by(BenchSolver solver, const Problem& problem, const Vector3d& z, long& solves) {
  Eigen::VectorXd r(rows_of(problem));
  Eigen::Index row = 0;
  for (const SummaryRun& run : problem.summary_runs) {
    ++solves;
    const Eigen::LLT<Eigen::Matrix2d> factor(run.measured.covariance);
    r.segment<2>(row) =
        factor.matrixL().solve(run.measured.vector - end_by(solver, scenario_at(run.scenario, z)));
    row += 2;
  }
  for (const TrajectoryRun& run : problem.trajectory_runs) {
    ++solves;
    Matrix2Xd off = -track_by(solver, scenario_at(run.scenario, z), times_of(run));
    for (Eigen::Index i = 0; i < off.cols(); ++i)
      off.col(i) += run.track.position[static_cast<std::size_t>(i)];
    r.segment(row, off.size()) = whitened(run, off.reshaped());
    row += off.size();
  }
  return r;
}

PlainResiduals by_differences(const Problem& problem, BenchSolver solver, double step, long& solves) {
  return [&problem, solver, step, &solves](const Vector3d& z, Eigen::MatrixX3d* jacobian) {
    const Eigen::VectorXd r = residuals_by(solver, problem, z, solves);
    if (jacobian) {
      jacobian->resize(r.size(), 3);
      for (Eigen::Index i = 0; i < 3; ++i) {
        const Vector3d h = step * Vector3d::Unit(i);  // relative for mu1 and mu2: logarithms
        jacobian->col(i) =
            (residuals_by(solver, problem, z + h, solves) - residuals_by(solver, problem, z - h, solves)) /
            (2 * step);
      }
    }
    return r;
  };
}

/// Residuals and derivatives by z of one campaign, one simulation a run.
PlainResiduals exact(const Problem& problem, long& solves) {
  return [&problem, &solves](const Vector3d& z, Eigen::MatrixX3d* jacobian) -> Eigen::VectorXd {
    if (!jacobian) return residuals_by(BenchSolver::ours, problem, z, solves);
    Eigen::VectorXd r(rows_of(problem));
    jacobian->resize(r.size(), 3);
    const Vector3d chain(std::exp(z(0)), std::exp(z(1)), 1);
    model::IntegrationOptions options;
    options.derivatives = {model::Parameter::mu1, model::Parameter::mu2, model::Parameter::lag};
    Eigen::Index row = 0;
    for (const SummaryRun& run : problem.summary_runs) {
      ++solves;
      const Eigen::LLT<Eigen::Matrix2d> factor(run.measured.covariance);
      const EndPoint end = end_point(scenario_at(run.scenario, z), options.derivatives, options.tolerance);
      r.segment<2>(row) = factor.matrixL().solve(run.measured.vector - end.position);
      jacobian->middleRows<2>(row) = factor.matrixL().solve(-end.jacobian * chain.asDiagonal());
      row += 2;
    }
    for (const TrajectoryRun& run : problem.trajectory_runs) {
      ++solves;
      model::Scenario scenario = scenario_at(run.scenario, z);
      const std::vector<double> times = times_of(run);
      scenario.duration = times.back();
      const model::Trajectory trajectory = model::integrate(scenario, options);
      Eigen::MatrixXd rows(2 * static_cast<Eigen::Index>(times.size()), 4);
      for (std::size_t i = 0; i < times.size(); ++i) {
        const auto at = trajectory.sensitive_at(std::min(times[i], trajectory.end_time()));
        const auto k = 2 * static_cast<Eigen::Index>(i);
        rows.block<2, 1>(k, 0) = run.track.position[i] - at.sample.position;
        rows.block<2, 3>(k, 1) = -at.position_jacobian * chain.asDiagonal();
      }
      rows = whitened(run, rows);
      r.segment(row, rows.rows()) = rows.col(0);
      jacobian->middleRows(row, rows.rows()) = rows.rightCols<3>();
      row += rows.rows();
    }
    return r;
  };
}

BenchAnswer plain(const PlainResiduals& residuals, int max_iterations) {
  const FitTruth guess = bench_first_guess();
  const PlainDescent end =
      descend(residuals, {std::log(guess.mu1), std::log(guess.mu2), guess.lag}, max_iterations);
  const auto back = [](const Vector3d& z) { return Vector3d(std::exp(z(0)), std::exp(z(1)), z(2)); };
  const Vector3d sd = end.covariance.diagonal().cwiseMax(0).cwiseSqrt();
  BenchAnswer answer;
  // Differences that are mostly noise can make J'J singular: an estimate without an interval is none.
  answer.converged = end.converged && sd.allFinite();
  answer.estimate = back(end.z);
  answer.low = back(end.z - 1.959964 * sd);
  answer.high = back(end.z + 1.959964 * sd);
  answer.sd = sd.cwiseProduct(Vector3d(answer.estimate(0), answer.estimate(1), 1));
  return answer;
}

}  // namespace

FitTruth bench_first_guess() {
  return {0.09, 0.015, 0.1};
}

BenchMethod our_fit(bool with_profiles, int starts) {
  return [with_profiles, starts](const Problem& problem) {
    FitOptions options;
    options.multi_starts = starts;
    options.profiles = with_profiles;
    const FitResult result = fit::estimate(problem, options);
    BenchAnswer answer;
    answer.converged = result.usable();
    for (Eigen::Index i = 0; i < 3; ++i) {
      const ParameterEstimate& p = result.parameters[static_cast<std::size_t>(i)];
      const Interval& interval = with_profiles ? p.profile_ci95 : p.ci95;
      answer.estimate(i) = p.estimate;
      answer.sd(i) = p.sd;
      answer.low(i) = interval.low;
      answer.high(i) = interval.high;
    }
    return answer;
  };
}

BenchMethod descent_with_exact_derivatives() {
  return [](const Problem& problem) {
    long solves = 0;
    BenchAnswer answer = plain(exact(problem, solves), 50);
    answer.solves = solves;
    return answer;
  };
}

BenchMethod descent_by_differences(BenchSolver solver, int max_iterations, double step) {
  return [solver, max_iterations, step](const Problem& problem) {
    long solves = 0;
    BenchAnswer answer = plain(by_differences(problem, solver, step, solves), max_iterations);
    answer.solves = solves;
    return answer;
  };
}

}  // namespace tribotrack::bench
