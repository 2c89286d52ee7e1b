#include "apps/bench/fit.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "apps/bench/peers.h"
#include "apps/bench/timing.h"
#include "fit/estimate.h"
#include "fit/prediction.h"
#include "fit/residuals/end_point.h"
#include "model/alpha_v.h"
#include "model/trajectory.h"

namespace tribotrack::bench {

using namespace fit;
using namespace fit::internal;

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using std::numbers::pi;

/// Where all descents start.
constexpr FitTruth kFirstGuess{0.09, 0.015, 0.1};

enum class Solver { ours, segmented_dormand_prince, paper_recipe };

/// What a method estimates from one campaign: mu1, mu2, lag.
struct Answer {
  Vector3d estimate = Vector3d::Zero(), sd = estimate;
  bool converged = false;
  double time = 0;  ///< s
};
using Fitting = std::function<Answer(const Problem&)>;

model::Scenario scenario_at(const model::Scenario& base, const Vector3d& z) {
  model::Scenario s = base;
  s.friction.nominal = std::exp(z(0));
  s.friction.reduced = std::exp(z(1));
  s.friction.lag = z(2);
  return s;
}

Vector2d end_by(Solver solver, const model::Scenario& scenario) {
  if (solver == Solver::ours) return end_point(scenario, {}, 1e-16).position;
  return dormand_prince(scenario, solver == Solver::paper_recipe ? paper_recipe()
                                                                 : segmented_dormand_prince(scenario, 1e-8))
      .position;
}

Eigen::VectorXd residuals_by(Solver solver, const Problem& problem, const Vector3d& z) {
  Eigen::VectorXd r(2 * static_cast<Eigen::Index>(problem.summary_runs.size()));
  Eigen::Index row = 0;
  for (const SummaryRun& run : problem.summary_runs) {
    const Eigen::LLT<Eigen::Matrix2d> factor(run.measured.covariance);
    r.segment<2>(row) =
        factor.matrixL().solve(run.measured.vector - end_by(solver, scenario_at(run.scenario, z)));
    row += 2;
  }
  return r;
}

/// Residuals at z; the Jacobian where it is not null.
using PlainResiduals = std::function<Eigen::VectorXd(const Eigen::Vector3d& z, Eigen::MatrixX3d* jacobian)>;

PlainResiduals by_differences(const Problem& problem, Solver solver, double step) {
  return [&problem, solver, step](const Vector3d& z, Eigen::MatrixX3d* jacobian) {
    const Eigen::VectorXd r = residuals_by(solver, problem, z);
    if (jacobian) {
      jacobian->resize(r.size(), 3);
      for (Eigen::Index i = 0; i < 3; ++i) {
        const Vector3d h = step * Vector3d::Unit(i);  // relative for mu1 and mu2: logarithms
        jacobian->col(i) =
            (residuals_by(solver, problem, z + h) - residuals_by(solver, problem, z - h)) / (2 * step);
      }
    }
    return r;
  };
}

/// What a researcher writes around a solver: a textbook Levenberg-Marquardt for three parameters.
struct PlainDescent {
  Eigen::Vector3d z = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< (J'J)^-1
  double chi2 = 0;
  bool converged = false;
};

/// Ends when a step changes no parameter by more than 1e-7 or chi-square by less than 1e-10 of it, without
/// convergence after max_iterations or when no step helps.
PlainDescent descend(const PlainResiduals& residuals, const Eigen::Vector3d& start, int max_iterations) {
  PlainDescent state;
  state.z = start;
  Eigen::MatrixX3d j;
  Eigen::VectorXd r = residuals(state.z, &j);
  state.chi2 = r.squaredNorm();
  double damping = 1e-3;
  for (int iteration = 0; iteration < max_iterations && !state.converged && damping < 1e12; ++iteration) {
    const Eigen::Matrix3d normal = j.transpose() * j;
    Eigen::Matrix3d damped = normal;
    damped.diagonal() += damping * normal.diagonal();
    const Eigen::Vector3d step = -damped.ldlt().solve(j.transpose() * r);
    const Eigen::Vector3d trial = state.z + step;
    const double chi2 = residuals(trial, nullptr).squaredNorm();
    if (!(chi2 <= state.chi2)) {
      damping *= 10;
      // A step this small that still does not help: the minimum, as far as these derivatives see it.
      state.converged = step.cwiseAbs().maxCoeff() < 1e-7;
      continue;
    }
    const bool settled = step.cwiseAbs().maxCoeff() < 1e-7 || state.chi2 - chi2 <= 1e-10 * chi2;
    state.z = trial;
    state.chi2 = chi2;
    damping *= 0.1;
    r = residuals(state.z, &j);
    state.converged = settled;
  }
  state.covariance = (j.transpose() * j).inverse();
  return state;
}

Answer plain(const PlainResiduals& residuals, int max_iterations) {
  const PlainDescent end = descend(
      residuals, {std::log(kFirstGuess.mu1), std::log(kFirstGuess.mu2), kFirstGuess.lag}, max_iterations);
  const Vector3d sd = end.covariance.diagonal().cwiseMax(0).cwiseSqrt();
  Answer answer;
  // Differences that are mostly noise can make J'J singular: an estimate without an interval is none.
  answer.converged = end.converged && sd.allFinite();
  answer.estimate = {std::exp(end.z(0)), std::exp(end.z(1)), end.z(2)};
  return answer;
}

/// estimate() on one thread, as `fit` calls it but for what is left out here.
Fitting our_fit(bool profiles, int starts) {
  return [profiles, starts](const Problem& problem) {
    FitOptions options;
    options.multi_starts = starts;
    options.profiles = profiles;
    const FitResult result = fit::estimate(problem, options);
    Answer answer;
    answer.converged = result.usable();
    for (Eigen::Index i = 0; i < 3; ++i) {
      const ParameterEstimate& p = result.parameters[static_cast<std::size_t>(i)];
      answer.estimate(i) = p.estimate;
      answer.sd(i) = p.sd;
    }
    return answer;
  };
}

Fitting descent_by_differences(Solver solver, int max_iterations, double step = 1e-6) {
  return [solver, max_iterations, step](const Problem& problem) {
    return plain(by_differences(problem, solver, step), max_iterations);
  };
}

struct Method {
  const char* name;
  Whose whose;
  Fitting fit;
  std::vector<Answer> answers = {};
};

std::vector<Method> methods_for(bool quick) {
  const int starts = quick ? 2 : FitOptions().multi_starts;
  return {
      {"tribotrack", Whose::ours, our_fit(true, starts)},
      {"tribotrack without profiles, one start", Whose::variant, our_fit(false, 1)},
      {"one descent, differences through our solver", Whose::peer, descent_by_differences(Solver::ours, 50)},
      {"one descent, differences through segmented Dormand-Prince 1e-8", Whose::peer,
       descent_by_differences(Solver::segmented_dormand_prince, 50)},
      {"one descent, differences through the paper's recipe", Whose::peer,
       descent_by_differences(Solver::paper_recipe, quick ? 4 : 15)},
      {"the same with differences of 1 %, above its noise", Whose::peer,
       descent_by_differences(Solver::paper_recipe, quick ? 4 : 40, 0.01)}};
}

ComparedRow judge(const Method& method, const Method& ours, const std::vector<FitTruth>& truths) {
  ComparedRow row{"14 displacements", "14 displacements", method.name, "", method.whose};
  const auto count = static_cast<double>(method.answers.size());
  double converged = 0, off_minimum = 0;
  Vector3d square = Vector3d::Zero();
  std::vector<double> times;
  for (std::size_t k = 0; k < method.answers.size(); ++k) {
    const Answer &answer = method.answers[k], &minimum = ours.answers[k];
    const Vector3d truth(truths[k].mu1, truths[k].mu2, truths[k].lag), unit(truth(0), truth(1), 1);
    converged += answer.converged;
    square += (answer.estimate - truth).cwiseQuotient(unit).cwiseAbs2() / count;
    off_minimum = std::max(
        off_minimum, (answer.estimate - minimum.estimate).cwiseQuotient(minimum.sd).cwiseAbs().maxCoeff());
    times.push_back(answer.time);
  }
  row.arrived = converged == count && off_minimum <= kSameMinimum;
  row.error = std::sqrt(square(0));
  row.time = median(times);
  row.details = {{"campaigns", count},
                 {"converged", converged},
                 {"off_minimum_sd", off_minimum},
                 {"mu2_rms_relative", std::sqrt(square(1))},
                 {"lag_rms_rad", std::sqrt(square(2))}};
  return row;
}

std::vector<FitTruth> draw_truths(int count) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<FitTruth> truths;
  for (int k = 0; k < count; ++k) {
    FitTruth truth;
    truth.mu1 = 0.08 + 0.03 * unit(random);
    truth.mu2 = truth.mu1 / 8 * (0.7 + 0.6 * unit(random));
    truth.lag = 0.05 + 0.25 * unit(random);
    truths.push_back(truth);
  }
  return truths;
}

}  // namespace

Problem simulated_campaign(const FitTruth& truth, unsigned seed, double cycles) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  Problem problem;
  problem.free = {FitParameter::mu1, FitParameter::mu2, FitParameter::lag};
  problem.start = {{FitParameter::mu1, kFirstGuess.mu1},
                   {FitParameter::mu2, kFirstGuess.mu2},
                   {FitParameter::lag, kFirstGuess.lag}};
  for (int k = 0; k < 14; ++k) {
    SummaryRun run;
    run.name = "run" + std::to_string(k + 1);
    const double phi = k < 8 ? k * pi / 4 : 0, dtau = k < 8 ? pi / 3 : (k - 7) * pi / 6;
    run.scenario.friction = {truth.mu1, truth.mu2, phi, dtau, truth.lag};
    run.scenario.cycles = cycles;
    const Vector2d exact_end = modelled_displacement(run.scenario);
    const double v = model::mean_velocity(exact_end, run.scenario.end_time());
    const double alpha_sd = pi / 180, v_sd = 0.02 * v;
    const Estimate alpha{model::displacement_angle(exact_end) + alpha_sd * normal(random), alpha_sd};
    const Estimate velocity{v + v_sd * normal(random), v_sd};
    run.measured = displacement_from_alpha_v(alpha, velocity, run.scenario.drive.angular_frequency,
                                             static_cast<int>(cycles));
    problem.summary_runs.push_back(run);
  }
  return problem;
}

Comparison bench_fit(const FitBenchOptions& options) {
  Comparison comparison{"fit",
                        "Error of a fit against run time",
                        "rms error of mu1",
                        "relative",
                        "CPU time of a campaign",
                        "truth of simulated campaigns; 1 degree on alpha and 2 % on v of a run",
                        1e9};
  const bool quick = options.quick;
  const int campaigns = quick ? 1 : 4;
  const std::vector<FitTruth> truths = draw_truths(campaigns);
  std::vector<Method> methods = methods_for(quick);
  for (int k = 0; k < campaigns; ++k) {
    const Problem problem = simulated_campaign(truths[static_cast<std::size_t>(k)],
                                               1000 + static_cast<unsigned>(k), quick ? 3 : 20);
    for (Method& method : methods) {
      const double begin = thread_seconds();
      method.answers.push_back(method.fit(problem));
      method.answers.back().time = thread_seconds() - begin;
    }
    if (options.progress) options.progress(k + 1, campaigns);
  }
  for (const Method& method : methods) comparison.rows.push_back(judge(method, methods.front(), truths));
  return comparison;
}

}  // namespace tribotrack::bench
