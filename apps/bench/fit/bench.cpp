#include "apps/bench/fit/bench.h"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <numbers>
#include <random>

#include "apps/bench/fit/methods.h"
#include "fit/estimate.h"
#include "fit/prediction.h"
#include "model/alpha_v.h"
#include "model/trajectory.h"

namespace tribotrack::bench {

using namespace fit;

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using std::numbers::pi;

double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

struct Entry {
  std::string method;
  bool ours = false;
  int campaigns = 0;  ///< slow methods see fewer: the first ones
  BenchMethod run;
  std::vector<BenchAnswer> answers = {};
};

std::vector<Entry> for_displacements(int campaigns, bool quick) {
  const int slow = quick ? 1 : 2, starts = quick ? 2 : 8;
  const int some = std::min(campaigns, 8 * slow), few = quick ? 1 : std::min(campaigns, 4 * slow);
  return {
      {"tribotrack", true, some, our_fit(false, starts)},
      {"tribotrack with profiles", true, few, our_fit(true, starts)},
      {"tribotrack, one start", true, some, our_fit(false, 1)},
      {"one descent, exact derivatives", true, campaigns, descent_with_exact_derivatives()},
      {"one descent, differences through our solver", false, campaigns,
       descent_by_differences(BenchSolver::ours, 50)},
      {"one descent, differences through segmented Dormand-Prince 1e-8", false, few,
       descent_by_differences(BenchSolver::segmented_dormand_prince, 50)},
      {"one descent, differences through the paper's recipe", false, slow,
       descent_by_differences(BenchSolver::paper_recipe, quick ? 4 : 15)},
      {"the same with differences of 1 %, above its noise", false, slow,
       descent_by_differences(BenchSolver::paper_recipe, quick ? 4 : 40, 0.01)},
  };
}

std::vector<Entry> for_tracks(int campaigns, bool quick) {
  const int starts = quick ? 2 : 8;
  return {
      {"tribotrack", true, campaigns, our_fit(false, starts)},
      {"tribotrack, one start", true, campaigns, our_fit(false, 1)},
      {"one descent, exact derivatives", true, campaigns, descent_with_exact_derivatives()},
      {"one descent, differences through our solver", false, campaigns,
       descent_by_differences(BenchSolver::ours, 50)},
      {"one descent, differences through the paper's recipe", false, 1,
       descent_by_differences(BenchSolver::paper_recipe, quick ? 1 : 15)},
      {"the same with differences of 1 %, above its noise", false, 1,
       descent_by_differences(BenchSolver::paper_recipe, quick ? 1 : 40, 0.01)},
  };
}

FitBenchRow judge(const Entry& entry, const Entry& first, const std::vector<FitTruth>& truths) {
  FitBenchRow row;
  row.method = entry.method;
  row.ours = entry.ours;
  row.campaigns = static_cast<int>(entry.answers.size());
  std::vector<double> times;
  for (std::size_t k = 0; k < entry.answers.size(); ++k) {
    const BenchAnswer& answer = entry.answers[k];
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
    const BenchAnswer& own = first.answers[k];
    const double off = (answer.estimate - own.estimate).cwiseQuotient(own.sd).cwiseAbs().maxCoeff();
    row.off_minimum = std::max(row.off_minimum, off);
  }
  row.rms_error = row.rms_error.cwiseSqrt();
  const auto middle = times.begin() + static_cast<std::ptrdiff_t>(times.size() / 2);
  std::nth_element(times.begin(), middle, times.end());
  row.time = *middle;
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

/// Problem with the starts all methods share.
Problem from_the_first_guess() {
  Problem problem;
  const FitTruth guess = bench_first_guess();
  problem.free = {FitParameter::mu1, FitParameter::mu2, FitParameter::lag};
  problem.start = {
      {FitParameter::mu1, guess.mu1}, {FitParameter::mu2, guess.mu2}, {FitParameter::lag, guess.lag}};
  return problem;
}

/// phi and dtau of the 14 runs.
std::vector<std::pair<double, double>> fourteen_runs() {
  std::vector<std::pair<double, double>> runs;
  for (int k = 0; k < 8; ++k) runs.emplace_back(k * pi / 4, pi / 3);
  for (int k = 1; k <= 6; ++k) runs.emplace_back(0, k * pi / 6);
  return runs;
}

model::Scenario scenario_of(const FitTruth& truth, const std::pair<double, double>& pulse, double cycles) {
  model::Scenario scenario;
  scenario.friction = {truth.mu1, truth.mu2, pulse.first, pulse.second, truth.lag};
  scenario.cycles = cycles;
  return scenario;
}

}  // namespace

Problem simulated_campaign(const FitTruth& truth, unsigned seed, double cycles) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  Problem problem = from_the_first_guess();
  for (const auto& pulse : fourteen_runs()) {
    SummaryRun run;
    run.name = "run" + std::to_string(problem.summary_runs.size() + 1);
    run.scenario = scenario_of(truth, pulse, cycles);
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

Problem simulated_tracks(const FitTruth& truth, unsigned seed, std::size_t points, double cycles) {
  constexpr double kSigma = 1e-6;
  std::mt19937_64 random(seed);
  std::normal_distribution<double> noise(0, kSigma);
  Problem problem = from_the_first_guess();
  for (const auto& pulse : fourteen_runs()) {
    TrajectoryRun run;
    run.name = "run" + std::to_string(problem.trajectory_runs.size() + 1);
    run.scenario = scenario_of(truth, pulse, cycles);
    run.track.platform_frame = true;
    const model::Trajectory trajectory = model::integrate(run.scenario);
    for (std::size_t k = 0; k < points; ++k) {
      const double time = trajectory.end_time() * static_cast<double>(k) / static_cast<double>(points - 1);
      run.track.time.push_back(time);
      run.track.position.push_back(trajectory.at(time).position + Vector2d(noise(random), noise(random)));
      run.track.covariance.push_back(kSigma * kSigma * Eigen::Matrix2d::Identity());
    }
    problem.trajectory_runs.push_back(run);
  }
  return problem;
}

std::vector<FitBenchRow> bench_fit(const FitBenchOptions& options) {
  struct Kind {
    std::string name;
    std::vector<Problem> problems;
    std::vector<Entry> entries;
  };
  const int campaigns = options.quick ? 2 : 40, tracked = options.quick ? 1 : 3;
  const std::vector<FitTruth> truths = draw_truths(campaigns);
  std::vector<Kind> kinds{{"14 displacements", {}, for_displacements(campaigns, options.quick)},
                          {"14 tracks", {}, for_tracks(tracked, options.quick)}};
  for (int k = 0; k < campaigns; ++k)
    kinds[0].problems.push_back(simulated_campaign(truths[static_cast<std::size_t>(k)],
                                                   1000 + static_cast<unsigned>(k), options.quick ? 3 : 20));
  for (int k = 0; k < tracked; ++k)
    kinds[1].problems.push_back(simulated_tracks(truths[static_cast<std::size_t>(k)],
                                                 2000 + static_cast<unsigned>(k), options.quick ? 60 : 2000,
                                                 options.quick ? 2 : 20));
  std::vector<FitBenchRow> rows;
  int done = 0;
  for (Kind& kind : kinds) {
    for (std::size_t k = 0; k < kind.problems.size(); ++k) {
      for (Entry& entry : kind.entries) {
        if (static_cast<int>(k) >= entry.campaigns) continue;
        const double begin = cpu_seconds();
        entry.answers.push_back(entry.run(kind.problems[k]));
        entry.answers.back().time = cpu_seconds() - begin;
      }
      if (options.progress) options.progress(++done, campaigns + tracked);
    }
    const std::size_t first = rows.size();
    for (const Entry& entry : kind.entries) {
      rows.push_back(judge(entry, kind.entries.front(), truths));
      rows.back().data = kind.name;
      rows.back().time_over_ours = rows.back().time / rows[first].time;
    }
  }
  return rows;
}

}  // namespace tribotrack::bench
