// Do 95 % intervals of fits to displacements cover the truth in 95 % of campaigns? Hundreds of cheap
// campaigns: simulated once, noise drawn for each.
#include "fit/coverage.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <random>

#include "fit/campaign.h"
#include "fit/estimate.h"

namespace tribotrack::fit {
namespace {

using test::SequentialCoverage;

constexpr int kMostCampaigns = 3000;

class Campaigns {
 public:
  Campaigns() {
    problem_.free = {FitParameter::mu1, FitParameter::mu2, FitParameter::lag};
    // First guesses off the truth by many standard deviations.
    problem_.start = {{FitParameter::mu1, 1.03 * truth_.mu1},
                      {FitParameter::mu2, 1.5 * truth_.mu2},
                      {FitParameter::lag, truth_.lag + 0.1}};
    for (const auto& scenario : test::fourteen(truth_))
      problem_.summary_runs.push_back(test::summary_run(scenario, 0.01, 0.02e-3));
  }
  std::vector<double> truth() const { return {truth_.mu1, truth_.mu2, truth_.lag}; }

  FitResult fit(unsigned seed, int index) const {
    std::seed_seq mixed{seed, static_cast<unsigned>(index)};
    std::mt19937 random(mixed);
    std::normal_distribution<double> normal;
    Problem problem = problem_;
    for (auto& run : problem.summary_runs) {
      const Eigen::Matrix2d root = run.measured.covariance.llt().matrixL();
      run.measured.vector += root * Eigen::Vector2d(normal(random), normal(random));
      derive_alpha_and_v(run.measured);
    }
    FitOptions options;
    options.multi_starts = 1;
    options.profiles = options.next_experiment = false;
    return estimate(problem, options);
  }

 private:
  test::Truth truth_;
  Problem problem_;
};

/// The parameters of one campaign are correlated: each campaign is one trial, of one parameter after the
/// other.
TEST(Coverage, OfDisplacementsIs95Percent) {
  const unsigned seed = 11;
  SCOPED_TRACE(seed);
  const Campaigns campaigns;
  const std::vector<double> truth = campaigns.truth();
  SequentialCoverage coverage(0.01);
  for (int k = 0; k < kMostCampaigns && !coverage.decided(); ++k) {
    const FitResult result = campaigns.fit(seed, k);
    const std::size_t i = static_cast<std::size_t>(k) % truth.size();
    const Interval& ci95 = result.parameters[i].ci95;
    coverage.add(ci95.low <= truth[i] && truth[i] <= ci95.high);
  }
  EXPECT_EQ(coverage.decision(), SequentialCoverage::Decision::nominal)
      << 100 * coverage.share() << " % of " << coverage.trials;
}

}  // namespace
}  // namespace tribotrack::fit
