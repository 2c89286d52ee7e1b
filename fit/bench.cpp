#include "fit/bench.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <ctime>
#include <numbers>
#include <random>

#include "fit/estimate.h"
#include "fit/internal/plain_descent.h"
#include "model/displacement_angle.h"
#include "model/peers.h"
#include "model/trajectory.h"

namespace tribotrack::fit {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using std::numbers::pi;

double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

const FitTruth kFirstGuess{0.09, 0.015, 0.1};

/// What a method says of one campaign, on the axes mu1, mu2, lag.
struct Answer {
  Vector3d estimate, sd, low, high;
  bool converged = false;
  double time = 0;
  long solves = 0;
};

using Method = std::function<Answer(const Problem&)>;

Answer ours(const Problem& problem, bool with_profiles, int starts) {
  FitOptions options;
  options.multi_starts = starts;
  options.profiles = with_profiles;
  const FitResult result = estimate(problem, options);
  Answer answer;
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
}

model::Scenario scenario_at(const SummaryRun& run, const Vector3d& z) {
  model::Scenario s = run.scenario;
  s.friction.nominal = std::exp(z(0));
  s.friction.reduced = std::exp(z(1));
  s.friction.lag = z(2);
  return s;
}

using Solver = std::function<Vector2d(const model::Scenario&)>;

Eigen::VectorXd whitened(const Problem& problem,
                         const std::function<Vector2d(const SummaryRun&)>& displacement) {
  Eigen::VectorXd r(2 * static_cast<Eigen::Index>(problem.summary_runs.size()));
  Eigen::Index row = 0;
  for (const SummaryRun& run : problem.summary_runs) {
    const Eigen::LLT<Eigen::Matrix2d> factor(run.measured.covariance);
    r.segment<2>(row) = factor.matrixL().solve(displacement(run));
    row += 2;
  }
  return r;
}

/// Residuals by any solver, derivatives by central differences.
internal::PlainResiduals by_differences(const Problem& problem, const Solver& solve, long& solves) {
  return [&problem, solve, &solves](const Vector3d& z, Eigen::MatrixX3d* jacobian) {
    const auto at = [&](const Vector3d& place) {
      return whitened(problem, [&](const SummaryRun& run) -> Vector2d {
        ++solves;
        return run.measured.vector - solve(scenario_at(run, place));
      });
    };
    const Eigen::VectorXd r = at(z);
    if (jacobian) {
      jacobian->resize(r.size(), 3);
      for (Eigen::Index i = 0; i < 3; ++i) {
        const double step = 1e-6;  // relative for mu1 and mu2, whose logarithms these are
        jacobian->col(i) = (at(z + step * Vector3d::Unit(i)) - at(z - step * Vector3d::Unit(i))) / (2 * step);
      }
    }
    return r;
  };
}

internal::PlainResiduals exact(const Problem& problem, long& solves) {
  return [&problem, &solves](const Vector3d& z, Eigen::MatrixX3d* jacobian) {
    const auto count = static_cast<Eigen::Index>(problem.summary_runs.size());
    if (jacobian) jacobian->resize(2 * count, 3);
    model::IntegrationOptions options;
    if (jacobian) options.derivatives = {model::Parameter::mu1, model::Parameter::mu2, model::Parameter::lag};
    Eigen::Index row = 0;
    return whitened(problem, [&](const SummaryRun& run) -> Vector2d {
      ++solves;
      const model::Scenario scenario = scenario_at(run, z);
      const model::Trajectory trajectory = model::integrate(scenario, options);
      if (jacobian) {
        const Eigen::LLT<Eigen::Matrix2d> factor(run.measured.covariance);
        const Vector3d chain(scenario.friction.nominal, scenario.friction.reduced, 1);
        jacobian->middleRows<2>(row) =
            factor.matrixL().solve(-trajectory.sensitive_end().position_jacobian * chain.asDiagonal());
        row += 2;
      }
      return run.measured.vector - trajectory.end().position;
    });
  };
}

Answer plain(const internal::PlainResiduals& residuals, int max_iterations) {
  const Vector3d start(std::log(kFirstGuess.mu1), std::log(kFirstGuess.mu2), kFirstGuess.lag);
  const internal::PlainDescent end = internal::descend(residuals, start, max_iterations);
  const auto back = [](const Vector3d& z) { return Vector3d(std::exp(z(0)), std::exp(z(1)), z(2)); };
  const Vector3d sd = end.covariance.diagonal().cwiseMax(0).cwiseSqrt();
  Answer answer;
  // Differences that are mostly noise can make J'J singular: an estimate without an interval is none.
  answer.converged = end.converged && sd.allFinite();
  answer.estimate = back(end.z);
  answer.low = back(end.z - 1.959964 * sd);
  answer.high = back(end.z + 1.959964 * sd);
  answer.sd = sd.cwiseProduct(Vector3d(answer.estimate(0), answer.estimate(1), 1));
  return answer;
}

Method plain_by_differences(const Solver& solve, int max_iterations = 50) {
  return [solve, max_iterations](const Problem& problem) {
    long solves = 0;
    Answer answer = plain(by_differences(problem, solve, solves), max_iterations);
    answer.solves = solves;
    return answer;
  };
}

struct Entry {
  std::string name;
  bool ours = false;
  int campaigns = 0;
  Method method;
  std::vector<Answer> answers = {};
};

/// Slow methods see fewer campaigns: the first ones.
std::vector<Entry> entries(int campaigns, bool quick) {
  const int slow_campaigns = quick ? 1 : 2, starts = quick ? 2 : 8;
  const Solver product = [](const model::Scenario& s) { return model::integrate(s).end().position; };
  const Solver segmented = [](const model::Scenario& s) {
    return model::dormand_prince(s, model::segmented_dormand_prince(s, 1e-8)).position;
  };
  const Solver recipe = [](const model::Scenario& s) {
    return model::dormand_prince(s, model::paper_recipe()).position;
  };
  std::vector<Entry> list;
  const int some = std::min(campaigns, 8 * slow_campaigns),
            few = quick ? 1 : std::min(campaigns, 4 * slow_campaigns);
  list.push_back({"tribotrack", true, some, [starts](const Problem& p) { return ours(p, false, starts); }});
  list.push_back(
      {"tribotrack with profiles", true, few, [starts](const Problem& p) { return ours(p, true, starts); }});
  list.push_back({"tribotrack, one start", true, some, [](const Problem& p) { return ours(p, false, 1); }});
  list.push_back({"one descent, exact derivatives", true, campaigns, [](const Problem& p) {
                    long solves = 0;
                    Answer answer = plain(exact(p, solves), 50);
                    answer.solves = solves;
                    return answer;
                  }});
  list.push_back(
      {"one descent, differences through our solver", false, campaigns, plain_by_differences(product)});
  list.push_back({"one descent, differences through segmented Dormand-Prince 1e-8", false, few,
                  plain_by_differences(segmented)});
  list.push_back({"one descent, differences through the paper's recipe", false, slow_campaigns,
                  plain_by_differences(recipe, quick ? 4 : 15)});
  return list;
}

FitBenchRow judge(const Entry& entry, const Entry& first, const std::vector<FitTruth>& truths) {
  FitBenchRow row;
  row.method = entry.name;
  row.ours = entry.ours;
  row.campaigns = static_cast<int>(entry.answers.size());
  std::vector<double> times;
  for (std::size_t k = 0; k < entry.answers.size(); ++k) {
    const Answer& answer = entry.answers[k];
    const Vector3d truth(truths[k].mu1, truths[k].mu2, truths[k].lag);
    const Vector3d unit(truths[k].mu1, truths[k].mu2, 1);
    const double share = 1.0 / static_cast<double>(entry.answers.size());
    row.converged += answer.converged;
    times.push_back(answer.time);
    row.solves += share * static_cast<double>(answer.solves);
    row.rms_error += share * (answer.estimate - truth).cwiseQuotient(unit).cwiseAbs2();
    row.mean_sd += share * answer.sd.cwiseQuotient(unit);
    for (Eigen::Index i = 0; i < 3; ++i)
      row.covered(i) += share * (answer.converged && answer.low(i) <= truth(i) && truth(i) <= answer.high(i));
    if (k >= first.answers.size()) continue;
    const Answer& own = first.answers[k];
    const double off = (answer.estimate - own.estimate).cwiseQuotient(own.sd).cwiseAbs().maxCoeff();
    row.off_minimum = std::max(row.off_minimum, off);
  }
  row.rms_error = row.rms_error.cwiseSqrt();
  const auto middle = times.begin() + static_cast<std::ptrdiff_t>(times.size() / 2);
  std::nth_element(times.begin(), middle, times.end());
  row.time = *middle;
  return row;
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
  const auto add = [&](double phi, double dtau) {
    SummaryRun run;
    run.name = "run" + std::to_string(problem.summary_runs.size() + 1);
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
  };
  for (int k = 0; k < 8; ++k) add(k * pi / 4, pi / 3);
  for (int k = 1; k <= 6; ++k) add(0, k * pi / 6);
  return problem;
}

std::vector<FitBenchRow> bench_fit(const FitBenchOptions& options) {
  const int campaigns = options.quick ? 2 : 40;
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<FitTruth> truths;
  std::vector<Problem> problems;
  for (int k = 0; k < campaigns; ++k) {
    FitTruth truth;
    truth.mu1 = 0.08 + 0.03 * unit(random);
    truth.mu2 = truth.mu1 / 8 * (0.7 + 0.6 * unit(random));
    truth.lag = 0.05 + 0.25 * unit(random);
    truths.push_back(truth);
    problems.push_back(simulated_campaign(truth, 1000 + static_cast<unsigned>(k), options.quick ? 3 : 20));
  }
  std::vector<Entry> list = entries(campaigns, options.quick);
  for (int k = 0; k < campaigns; ++k) {
    for (Entry& entry : list) {
      if (k >= entry.campaigns) continue;
      const double begin = cpu_seconds();
      entry.answers.push_back(entry.method(problems[static_cast<std::size_t>(k)]));
      entry.answers.back().time = cpu_seconds() - begin;
    }
    if (options.progress) options.progress(k + 1, campaigns);
  }
  std::vector<FitBenchRow> rows;
  for (const Entry& entry : list) rows.push_back(judge(entry, list.front(), truths));
  for (FitBenchRow& row : rows) row.time_over_ours = row.time / rows.front().time;
  return rows;
}

}  // namespace tribotrack::fit
