#include "apps/bench/comparison.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <random>
#include <unsupported/Eigen/NonLinearOptimization>
#include <unsupported/Eigen/NumericalDiff>

#include "apps/bench/peers.h"
#include "apps/bench/timing.h"
#include "fit/estimate.h"
#include "fit/prediction.h"
#include "fit/residuals/end_point.h"
#include "model/alpha_v.h"
#include "model/trajectory.h"

namespace tribotrack::bench {

namespace {

/// One method over the scenes of a group: in each its fastest row that reaches the target.
struct InGroup {
  std::string method;
  std::map<std::string, const ComparedRow*> rows = {};  ///< by their scenes
  double of(double ComparedRow::*number) const {
    std::vector<double> values;
    for (const auto& [scene, row] : rows) values.push_back(row->*number);
    return upper_median(values);
  }
  double error() const { return of(&ComparedRow::error); }
  double time() const { return of(&ComparedRow::time); }
};

std::vector<InGroup> methods_in(const Comparison& comparison, const std::string& group, bool ours) {
  std::vector<InGroup> methods;
  for (const ComparedRow& row : comparison.rows) {
    const bool reaches = row.arrived && (comparison.target == 0 || row.error <= comparison.target);
    if (row.group != group || row.ours != ours || !reaches) continue;
    auto method = std::ranges::find(methods, row.method, &InGroup::method);
    if (method == methods.end()) method = methods.insert(methods.end(), {row.method});
    const ComparedRow*& best = method->rows[row.scene];
    if (!best || row.time < best->time) best = &row;
  }
  return methods;
}

/// Who arrives in most scenes; among these the fastest, or without a target the most accurate.
const InGroup* best_of(const std::vector<InGroup>& methods, bool by_time) {
  const auto worse = [by_time](const InGroup& a, const InGroup& b) {
    if (a.rows.size() != b.rows.size()) return a.rows.size() < b.rows.size();
    return by_time ? a.time() > b.time() : a.error() > b.error();
  };
  return methods.empty() ? nullptr : &*std::ranges::max_element(methods, worse);
}

std::string times_text(double ratio) {
  return fmt::format("x{:.2f}", ratio < 1 ? 1 / ratio : ratio);
}

std::string who_wins(const InGroup* own, const InGroup* peer, const Comparison& comparison) {
  const bool by_time = comparison.target > 0;
  const std::string arrives = by_time && std::isfinite(comparison.target)
                                  ? fmt::format("reaches {:g} {}", comparison.target, comparison.unit)
                                  : "arrives";
  if (!own && !peer) return "nobody " + arrives;
  if (!peer) return "tribotrack alone " + arrives;
  if (!own) return "PEER WINS: it alone " + arrives;
  const double time = peer->time() / own->time(), error = peer->error() / own->error();
  const std::string faster = (time < 1 ? "PEER WINS on time " : "tribotrack faster ") + times_text(time);
  if (by_time) return faster;
  return (error < 1 ? "PEER WINS on error " : "tribotrack closer ") + times_text(error) + ", " + faster;
}

/// "3.2 us", "3.2 ms", "3.2 s".
std::string time_text(double seconds) {
  if (seconds < 1e-3) return fmt::format("{:.3g} us", 1e6 * seconds);
  return seconds < 1 ? fmt::format("{:.3g} ms", 1e3 * seconds) : fmt::format("{:.3g} s", seconds);
}

}  // namespace

std::vector<SummaryLine> summary_of(const Comparison& comparison) {
  std::vector<SummaryLine> lines;
  std::vector<std::string> groups;
  for (const ComparedRow& row : comparison.rows)
    if (std::ranges::find(groups, row.group) == groups.end()) groups.push_back(row.group);
  const bool by_time = comparison.target > 0;
  for (const std::string& group : groups) {
    const auto ours = methods_in(comparison, group, true), peers = methods_in(comparison, group, false);
    const InGroup *own = best_of(ours, by_time), *peer = best_of(peers, by_time);
    const auto told = [&](const InGroup* method) {
      return method ? fmt::format("{}, {:.3g} {} ({})", time_text(method->time()), method->error(),
                                  comparison.unit, method->method)
                    : "-";
    };
    lines.push_back({fmt::format("{}, {}: {}, {}", comparison.name, group, comparison.time, comparison.error),
                     told(own), told(peer), who_wins(own, peer, comparison)});
  }
  return lines;
}

using namespace fit;
using namespace fit::internal;

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using std::numbers::pi;

/// Where all descents start.
constexpr FitTruth kFirstGuess{0.09, 0.015, 0.1};

/// What a method estimates from one campaign: mu1, mu2, lag.
struct Answer {
  Vector3d estimate = Vector3d::Zero(), sd = estimate;
  bool converged = false;
  double time = 0;  ///< s
};
using Fitting = std::function<Answer(const Problem&)>;
using EndBySolver = std::function<Vector2d(const model::Scenario&)>;

/// In standard deviations, at z: the logarithms of mu1 and mu2, and 1 + lag, so that a share of it is never
/// small.
Eigen::VectorXd residuals_at(const Vector3d& z, const EndBySolver& end, const Problem& problem) {
  Eigen::VectorXd r(2 * static_cast<Eigen::Index>(problem.summary_runs.size()));
  Eigen::Index row = 0;
  for (const SummaryRun& run : problem.summary_runs) {
    model::Scenario scenario = run.scenario;
    scenario.friction.nominal = std::exp(z(0));
    scenario.friction.reduced = std::exp(z(1));
    scenario.friction.lag = z(2) - 1;
    const Eigen::LLT<Eigen::Matrix2d> factor(run.measured.covariance);
    r.segment<2>(row) = factor.matrixL().solve(run.measured.vector - end(scenario));
    row += 2;
  }
  return r;
}

/// Residuals as MINPACK takes them.
struct Differenced {
  using Scalar = double;
  using InputType = Eigen::VectorXd;
  using ValueType = Eigen::VectorXd;
  using JacobianType = Eigen::MatrixXd;
  enum { InputsAtCompileTime = Eigen::Dynamic, ValuesAtCompileTime = Eigen::Dynamic };
  const Problem* problem;
  EndBySolver end;
  int inputs() const { return 3; }
  int values() const { return 2 * static_cast<int>(problem->summary_runs.size()); }
  int operator()(const Eigen::VectorXd& z, Eigen::VectorXd& r) const {
    r = residuals_at(z, end, *problem);
    return 0;
  }
};

/// What a researcher writes around a solver: MINPACK's Levenberg-Marquardt (Eigen's) for three parameters
/// with central differences of this relative step. Ends when a step changes parameters by less than 1e-7 or
/// chi-square by less than 1e-10 of it, without convergence after so many evaluations.
Fitting descent_by_differences(const EndBySolver& end, int max_evaluations, double step = 1e-6) {
  return [end, max_evaluations, step](const Problem& problem) {
    Eigen::NumericalDiff<Differenced, Eigen::Central> differenced({&problem, end}, step * step);
    Eigen::LevenbergMarquardt<decltype(differenced)> descent(differenced);
    descent.parameters.xtol = 1e-7;
    descent.parameters.ftol = 1e-10;
    descent.parameters.maxfev = max_evaluations;
    Eigen::VectorXd z(3);
    z << std::log(kFirstGuess.mu1), std::log(kFirstGuess.mu2), 1 + kFirstGuess.lag;
    const auto status = descent.minimize(z);
    Answer answer;
    answer.converged = status >= Eigen::LevenbergMarquardtSpace::RelativeReductionTooSmall &&
                       status <= Eigen::LevenbergMarquardtSpace::CosinusTooSmall;
    answer.estimate = {std::exp(z(0)), std::exp(z(1)), z(2) - 1};
    return answer;
  };
}

/// estimate() on one thread, as `fit` calls it.
Fitting our_fit(int starts) {
  return [starts](const Problem& problem) {
    FitOptions options;
    options.multi_starts = starts;
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

struct Method {
  const char* name;
  Fitting fit;
  std::vector<Answer> answers = {};
};

/// Ours first.
std::vector<Method> methods_for(bool quick) {
  using model::Scenario;
  const EndBySolver ours = [](const Scenario& s) { return end_point(s, {}, 1e-16).position; };
  const EndBySolver segmented = [](const Scenario& s) { return dormand_prince(s, 1e-8).position; };
  const EndBySolver recipe = [](const Scenario& s) { return paper_recipe(s).position; };
  return {{"tribotrack", our_fit(quick ? 2 : FitOptions().multi_starts)},
          {"one descent, differences through our solver", descent_by_differences(ours, 400)},
          {"one descent, differences through segmented Dormand-Prince 1e-8",
           descent_by_differences(segmented, 400)},
          {"one descent, differences through the paper's recipe",
           descent_by_differences(recipe, quick ? 30 : 110)},
          {"the same with differences of 1 %, above its noise",
           descent_by_differences(recipe, quick ? 30 : 280, 0.01)}};
}

ComparedRow judge(const Method& method, const Method& ours, const std::vector<FitTruth>& truths) {
  ComparedRow row{"14 displacements", "14 displacements", method.name, "", &method == &ours};
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
  row.time = upper_median(times);
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

Comparison bench_fit(const BenchOptions& options) {
  Comparison comparison{"fit",
                        "Error of a fit against run time",
                        "rms error of mu1",
                        "relative",
                        "CPU time of a campaign",
                        "truth of simulated campaigns; 1 degree on alpha and 2 % on v of a run",
                        HUGE_VAL};
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
