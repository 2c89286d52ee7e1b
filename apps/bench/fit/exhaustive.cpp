#include "apps/bench/fit/exhaustive.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <mutex>
#include <numbers>

#include "apps/bench/fit/designs.h"
#include "apps/bench/fit/plain_descent.h"
#include "fit/estimate.h"
#include "model/batch.h"
#include "model/parallel.h"
#include "model/trajectory.h"

namespace tribotrack::bench {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;  ///< ln mu1, ln mu2, lag
using std::numbers::pi;

model::Scenario scenario_at(const model::Scenario& base, const Vector3d& z) {
  model::Scenario s = base;
  s.friction.nominal = std::exp(std::clamp(z(0), -40.0, 20.0));
  s.friction.reduced = std::exp(std::clamp(z(1), -40.0, 20.0));
  s.friction.lag = z(2);
  return s;
}

class Displacements {
 public:
  explicit Displacements(const fit::Problem& problem) : runs_(problem.summary_runs) {
    for (const auto& run : runs_) factors_.emplace_back(run.measured.covariance);
  }
  std::size_t count() const { return runs_.size(); }
  const model::Scenario& scenario(std::size_t run) const { return runs_[run].scenario; }
  Vector2d residual(std::size_t run, const Vector2d& position) const {
    return factors_[run].matrixL().solve(runs_[run].measured.vector - position);
  }
  double chi2(const Vector3d& z) const { return residuals(z, nullptr).squaredNorm(); }
  Eigen::VectorXd residuals(const Vector3d& z, Eigen::MatrixX3d* jacobian) const {
    const auto rows = 2 * static_cast<Eigen::Index>(count());
    Eigen::VectorXd r(rows);
    if (jacobian) jacobian->resize(rows, 3);
    model::IntegrationOptions how;
    how.dense = false;
    if (jacobian) how.derivatives = {model::Parameter::mu1, model::Parameter::mu2, model::Parameter::lag};
    for (std::size_t run = 0; run < count(); ++run) {
      const auto row = 2 * static_cast<Eigen::Index>(run);
      const model::Scenario s = scenario_at(scenario(run), z);
      const model::Trajectory motion = model::integrate(s, how);
      r.segment<2>(row) = residual(run, motion.end().position);
      if (!jacobian) continue;
      const Vector3d chain(s.friction.nominal, s.friction.reduced, 1);
      jacobian->middleRows<2>(row) =
          factors_[run].matrixL().solve(-motion.sensitive_end().position_jacobian * chain.asDiagonal());
    }
    return r;
  }

 private:
  const std::vector<fit::SummaryRun>& runs_;
  std::vector<Eigen::LLT<Eigen::Matrix2d>> factors_;
};

constexpr int kDescentsAround = 40;
constexpr double kAround = 0.03;  ///< sd of ln mu1, ln mu2 and of the lag

/// chi^2 on a grid, periodic in the lag.
class Grid {
 public:
  static constexpr int kMu1 = 24, kRatio = 12, kLag = 36, kPoints = kMu1 * kRatio * kLag;

  Grid(const Displacements& data, double threshold) : threshold_(threshold), chi2_(kPoints, 0.0) {
    const std::size_t runs = data.count();
    model::BatchOptions options;
    options.tolerance = 1e-5;
    const auto outcome = model::solve_batch(
        kPoints * runs,
        [&](std::size_t k) {
          return scenario_at(data.scenario(k % runs), point(static_cast<int>(k / runs)));
        },
        options);
    for (std::size_t k = 0; k < kPoints * runs; ++k)
      chi2_[k / runs] += outcome.ends[k].status == model::BatchStatus::done
                             ? data.residual(k % runs, outcome.ends[k].position).squaredNorm()
                             : HUGE_VAL;
  }

  Vector3d point(int k) const {
    const double mu1 = std::log(0.1 * threshold_) + std::log(100) * (k / (kRatio * kLag)) / (kMu1 - 1);
    const double ratio = std::log(0.005) + std::log(300) * (k / kLag % kRatio) / (kRatio - 1);
    return {mu1, mu1 + ratio, 2 * pi * (k % kLag) / kLag - pi};
  }
  /// None of its neighbours is below, and none before it on the same plain.
  bool lowest(int k) const {
    const int mu1 = k / (kRatio * kLag), ratio = k / kLag % kRatio, lag = k % kLag;
    const double here = chi2_[static_cast<std::size_t>(k)];
    for (int i = std::max(0, mu1 - 1); i <= std::min(kMu1 - 1, mu1 + 1); ++i)
      for (int j = std::max(0, ratio - 1); j <= std::min(kRatio - 1, ratio + 1); ++j)
        for (int l = lag - 1; l <= lag + 1; ++l) {
          const int other = (i * kRatio + j) * kLag + (l + kLag) % kLag;
          const double there = chi2_[static_cast<std::size_t>(other)];
          if (there < here || (other < k && there < here + 1e-6)) return false;
        }
    return true;
  }

 private:
  double threshold_;
  std::vector<double> chi2_;
};

/// Tries both ways along each axis and each diagonal, halving the step where none helps.
void compass_search(const Displacements& data, Vector3d& z, double& chi2) {
  for (double step = 0.02; step > 1e-7;) {
    bool helped = false;
    for (int k = 1; k < 27; ++k) {
      const Vector3d way(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1);
      const Vector3d trial = z + step * way;
      const double there = data.chi2(trial);
      if (!(there < chi2 - 1e-9)) continue;
      z = trial;
      chi2 = there;
      helped = true;
    }
    if (!helped) step /= 2;
  }
}

FitTruth truth_of(const Vector3d& z) {
  return {std::exp(z(0)), std::exp(z(1)), std::remainder(z(2), 2 * pi)};
}

}  // namespace

ExhaustiveMinimum exhaustive_minimum(const fit::Problem& problem, int random) {
  const Displacements data(problem);
  const model::Drive& drive = data.scenario(0).drive;
  const Grid grid(data, drive.amplitude * drive.angular_frequency * drive.angular_frequency / drive.gravity);
  std::vector<int> starts;
  for (int k = 0; k < Grid::kPoints; ++k)
    if (grid.lowest(k)) starts.push_back(k);
  std::mt19937 dice(1);
  for (int k = 0; k < random; ++k)
    starts.push_back(std::uniform_int_distribution<int>(0, Grid::kPoints - 1)(dice));

  const PlainResiduals residuals = [&](const Vector3d& z, Eigen::MatrixX3d* jacobian) {
    return data.residuals(z, jacobian);
  };
  std::vector<PlainDescent> ends;
  for (const int start : starts) ends.push_back(descend(residuals, grid.point(start), 60));
  std::sort(ends.begin(), ends.end(), [](const auto& a, const auto& b) { return a.chi2 < b.chi2; });
  // Next to the threshold valleys lie a hundredth apart: descents from around the best end, as long as they
  // help.
  std::normal_distribution<double> around(0, kAround);
  for (bool helped = true; helped;) {
    helped = false;
    const Vector3d centre = ends.front().z;
    for (int k = 0; k < kDescentsAround; ++k) {
      const Vector3d start = centre + Vector3d(around(dice), around(dice), around(dice));
      const PlainDescent end = descend(residuals, start, 60);
      if (!(end.chi2 < ends.front().chi2 - 1e-4)) continue;
      ends.front() = end;
      helped = true;
    }
  }
  PlainDescent& best = ends.front();
  compass_search(data, best.z, best.chi2);
  return {best.chi2, truth_of(best.z), Grid::kPoints, static_cast<int>(starts.size())};
}

CoverageCampaign search_campaign(const SearchBenchOptions& options, int index) {
  const int runs = 3 + index % 12;
  const NoiseLevel level = index / 12 % 2 == 0 ? NoiseLevel::low : NoiseLevel::high;
  return draw_random_runs(runs, level, options.seed, index);
}

FoundMinimum minimum_of_fit(const fit::Problem& problem) {
  fit::FitOptions search_alone;
  search_alone.profiles = search_alone.next_experiment = search_alone.estimate_scatter = false;
  const fit::FitResult result = fit::estimate(problem, search_alone);
  return {result.chi2_before_scatter,
          {result.parameters[0].estimate, result.parameters[1].estimate, result.parameters[2].estimate}};
}

std::vector<SearchOutcome> search_outcomes(const SearchBenchOptions& options) {
  std::vector<SearchOutcome> outcomes(static_cast<std::size_t>(options.campaigns));
  int done = 0;
  std::mutex mutex;
  parallel_for(outcomes.size(), options.threads, [&](std::size_t k) {
    const int index = static_cast<int>(k);
    const fit::Problem problem = search_campaign(options, index).problem;
    const ExhaustiveMinimum least = exhaustive_minimum(problem);
    outcomes[k] = {index,
                   static_cast<int>(problem.summary_runs.size()),
                   minimum_of_fit(problem),
                   {least.chi2, least.at}};
    const std::lock_guard lock(mutex);
    if (options.progress) options.progress(++done, options.campaigns);
  });
  return outcomes;
}

}  // namespace tribotrack::bench
