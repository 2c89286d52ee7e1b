#include "apps/bench/fit/bench.h"

#include <gtest/gtest.h>

#include <cmath>

#include "apps/bench/fit/plain_descent.h"
#include "fit/estimate.h"
#include "fit/prediction.h"

namespace tribotrack::bench {

using namespace fit;

namespace {

TEST(PlainDescent, SolvesALinearProblemExactly) {
  Eigen::MatrixX3d a(4, 3);
  a << 1, 2, 0, 0, 1, 1, 3, 0, 1, 1, 1, 1;
  const Eigen::Vector3d truth(0.3, -2, 5);
  const auto residuals = [&](const Eigen::Vector3d& z, Eigen::MatrixX3d* jacobian) -> Eigen::VectorXd {
    if (jacobian) *jacobian = a;
    return a * (z - truth);
  };
  const auto end = descend(residuals, Eigen::Vector3d::Zero(), 50);
  EXPECT_TRUE(end.converged);
  EXPECT_LT((end.z - truth).norm(), 1e-9);
  EXPECT_LT((end.covariance - (a.transpose() * a).inverse()).norm(), 1e-12);
}

TEST(PlainDescent, SaysWhenItDidNotArrive) {
  const auto valley = [](const Eigen::Vector3d& z, Eigen::MatrixX3d* jacobian) -> Eigen::VectorXd {
    if (jacobian) {
      jacobian->resize(3, 3);
      *jacobian << -20 * z(0), 10, 0, -1, 0, 0, 0, 0, 1;
    }
    return Eigen::Vector3d(10 * (z(1) - z(0) * z(0)), 1 - z(0), z(2));
  };
  EXPECT_FALSE(descend(valley, {-1.2, 1, 0}, 2).converged);
  const auto end = descend(valley, {-1.2, 1, 0}, 200);
  EXPECT_TRUE(end.converged);
  EXPECT_LT((end.z - Eigen::Vector3d(1, 1, 0)).norm(), 1e-6);
}

TEST(SimulatedCampaign, ScattersByWhatItStates) {
  const FitTruth truth{0.1, 0.0125, 0.2};
  const Problem problem = simulated_campaign(truth, 5, 5);
  ASSERT_EQ(problem.summary_runs.size(), 14u);
  double chi2 = 0;
  for (const SummaryRun& run : problem.summary_runs) {
    const Eigen::Vector2d off = run.measured.vector - modelled_displacement(run.scenario);
    chi2 += off.dot(run.measured.covariance.inverse() * off);
  }
  // 28 degrees of freedom: within 4 standard deviations.
  EXPECT_NEAR(chi2, 28, 4 * std::sqrt(56.0));
  EXPECT_EQ(simulated_campaign(truth, 5, 5).summary_runs[3].measured.vector,
            problem.summary_runs[3].measured.vector);
}

TEST(FitBench, QuickRunComparesTheMethodsAtOneMinimum) {
  FitBenchOptions options;
  options.quick = true;
  const auto rows = bench_fit(options);
  ASSERT_EQ(rows.size(), 14u);
  EXPECT_EQ(rows[0].method, "tribotrack");
  EXPECT_EQ(rows[0].off_minimum, 0);
  EXPECT_DOUBLE_EQ(rows[0].time_over_ours, 1);
  for (const FitBenchRow& row : rows) {
    EXPECT_GE(row.campaigns, 1);
    EXPECT_GT(row.time, 0);
    EXPECT_GE(row.covered.minCoeff(), 0);
    EXPECT_LE(row.covered.maxCoeff(), 1);
  }
  // Exact derivatives and good differences come to the same minimum, another implementation of it all.
  for (const std::size_t k : {2u, 3u, 4u}) {
    EXPECT_EQ(rows[k].converged, rows[k].campaigns) << rows[k].method;
    EXPECT_LT(rows[k].off_minimum, 1e-3) << rows[k].method;
  }
  EXPECT_LT(rows[3].solves, rows[4].solves);
  EXPECT_EQ(rows[7].data, "14 displacements");
  EXPECT_EQ(rows[8].data, "14 tracks");
  for (const std::size_t k : {8u, 9u, 10u, 11u}) {
    EXPECT_EQ(rows[k].converged, rows[k].campaigns) << rows[k].method;
    EXPECT_LT(rows[k].off_minimum, 1e-2) << rows[k].method;
  }
  EXPECT_LT(rows[0].rms_error(0), 0.1);
}

}  // namespace
}  // namespace tribotrack::bench
