#include "apps/bench/fit/coverage.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <mutex>
#include <numbers>
#include <random>

#include "apps/bench/peers/baselines.h"
#include "fit/estimate.h"
#include "fit/tools/parallel.h"

namespace tribotrack::bench {

using namespace fit;

namespace {

using std::numbers::pi;

/// What one fit said of its parameters.
struct Outcome {
  bool slipping = true, tilted = false, usable = false, weak = false;
  std::vector<bool> covered, covered_by_profile;
};

bool holds(const Interval& interval, double truth) {
  return interval.low <= truth && truth <= interval.high;
}

Outcome judge(const CoverageCampaign& campaign, bool profiles) {
  FitOptions options;
  options.profiles = profiles;
  options.next_experiment = false;
  const FitResult result = estimate(campaign.problem, options);
  Outcome outcome{campaign.slipping,
                  campaign.tilted,
                  result.usable(),
                  result.identifiability.verdict == Verdict::weak,
                  {},
                  {}};
  for (std::size_t i = 0; i < campaign.truth.size(); ++i) {
    outcome.covered.push_back(holds(result.parameters[i].ci95, campaign.truth[i]));
    outcome.covered_by_profile.push_back(holds(result.parameters[i].profile_ci95, campaign.truth[i]));
  }
  return outcome;
}

std::string kind_of(const Outcome& outcome) {
  return std::string(outcome.slipping ? "slipping" : "sticking") + (outcome.tilted ? ", tilt fitted" : "");
}

}  // namespace

CoverageCampaign coverage_campaign(std::uint64_t seed, int index) {
  std::seed_seq mixed{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32),
                      static_cast<std::uint32_t>(index)};
  std::mt19937_64 random(mixed);
  std::normal_distribution<double> normal;
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  CoverageCampaign campaign;
  campaign.slipping = index % 5 < 3;
  campaign.tilted = index / 5 % 2 == 1;
  const double mu1 = campaign.slipping ? uniform(0.07, 0.108) : uniform(0.116, 0.128);
  const double mu2 = mu1 * uniform(0.05, 0.3), lag = uniform(-0.5, 0.5);
  Problem& problem = campaign.problem;
  problem.free = {FitParameter::mu1, FitParameter::mu2, FitParameter::lag};
  campaign.truth = {mu1, mu2, lag};
  model::Scenario truth;
  truth.friction = {mu1, mu2, 0, 0, lag};
  if (campaign.tilted) {
    truth.drive.tilt_x = pi / 1800 * normal(random);
    truth.drive.tilt_y = pi / 1800 * normal(random);
    problem.free.insert(problem.free.end(), {FitParameter::tilt_x, FitParameter::tilt_y});
    campaign.truth.insert(campaign.truth.end(), {truth.drive.tilt_x, truth.drive.tilt_y});
  }
  const auto film = [&](double phi, double dtau) {
    model::Scenario scenario = truth;
    scenario.friction.phase = phi;
    scenario.friction.pulse_width = dtau;
    const Eigen::Vector2d exact = dormand_prince(scenario, segmented_dormand_prince(scenario, 1e-9)).position;
    SummaryRun run;
    run.name = "run" + std::to_string(problem.summary_runs.size() + 1);
    run.scenario = scenario;
    run.scenario.friction.nominal = run.scenario.friction.reduced = 0.05;  // the fit does not see the truth
    run.scenario.friction.lag = run.scenario.drive.tilt_x = run.scenario.drive.tilt_y = 0;
    const double sigma = 0.01 * exact.norm() + 1e-6;
    run.measured.vector = exact + sigma * Eigen::Vector2d(normal(random), normal(random));
    run.measured.covariance = sigma * sigma * Eigen::Matrix2d::Identity();
    run.measured.duration = scenario.end_time();
    run.measured.cycles = static_cast<int>(scenario.cycles);
    derive_alpha_and_v(run.measured);
    problem.summary_runs.push_back(run);
  };
  const double dtau = uniform(0.6, 1.6), phi = uniform(0, 2 * pi);
  for (int k = 0; k < 8; ++k) film(k * pi / 4, dtau);
  for (int k = 1; k <= 6; ++k) film(phi, k * pi / 6);
  return campaign;
}

std::vector<CoverageRow> coverage(const CoverageOptions& options) {
  std::vector<Outcome> outcomes(static_cast<std::size_t>(options.campaigns));
  std::atomic<int> done{0};
  std::mutex mutex;
  fit::internal::parallel_for(outcomes.size(), options.threads, [&](std::size_t k) {
    outcomes[k] = judge(coverage_campaign(options.seed, static_cast<int>(k)), options.profiles);
    const std::lock_guard lock(mutex);
    if (options.progress) options.progress(++done, options.campaigns);
  });

  std::vector<CoverageRow> rows;
  const char* names[] = {"mu1", "mu2", "phase_lag_rad", "tilt_x_rad", "tilt_y_rad"};
  const auto row_for = [&](const std::string& kind, std::size_t i) -> CoverageRow& {
    for (CoverageRow& row : rows)
      if (row.kind == kind && row.parameter == names[i]) return row;
    rows.push_back({kind, names[i]});
    return rows.back();
  };
  for (const char* kind : {"all", "slipping", "slipping, tilt fitted", "sticking", "sticking, tilt fitted"})
    for (const Outcome& outcome : outcomes)
      for (std::size_t i = 0; i < outcome.covered.size(); ++i) {
        if (std::string(kind) != "all" && kind != kind_of(outcome)) continue;
        CoverageRow& row = row_for(kind, i);
        row.unusable += !outcome.usable;
        if (!outcome.usable) continue;
        ++row.campaigns;
        row.weak += outcome.weak;
        row.covered += outcome.covered[i];
        row.covered_by_profile += outcome.covered_by_profile[i];
      }
  return rows;
}

}  // namespace tribotrack::bench
