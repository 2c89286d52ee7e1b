// The minimum of the full model: what it says of itself, wherever the search for it passed.
#include <gtest/gtest.h>

#include "fit/campaign.h"
#include "fit/minimum/minimise.h"
#include "model/rival_laws.h"

namespace tribotrack::fit::internal {
namespace {

// Under a law that counts far more than is known of it the laws' effect is all but linear.
Problem strong_stribeck() {
  Problem problem;
  problem.free = {FitParameter::mu1, FitParameter::mu2, FitParameter::lag};
  for (const model::Scenario& truth : test::fourteen({0.105, 0.04, -0.08})) {
    SummaryRun run;
    run.scenario = truth;
    run.scenario.friction.nominal = run.scenario.friction.reduced = 0.05;
    run.scenario.friction.lag = 0;
    const model::RivalLaw law{.stribeck = 0.45};
    const Eigen::Vector2d moved = rival_positions(truth, {truth.end_time()}, std::span(&law, 1));
    const double v = moved.norm() / truth.end_time();
    run.measured = displacement_from_alpha_v({std::atan2(moved.y(), moved.x()), 0.005}, {v, 0.005 * v},
                                             truth.drive.angular_frequency, 20);
    problem.summary_runs.push_back(run);
  }
  problem.conditions = {
      {FitParameter::tilt_x, 0.002, "test"},    {FitParameter::tilt_y, 0.002, "test"},
      {FitParameter::stribeck, 0.1, "test"},    {FitParameter::viscous, 1, "test"},
      {FitParameter::gate_edges, 0.01, "test"}, {FitParameter::amplitude_ratio, 0.01, "test"}};
  return problem;
}

TEST(FullModel, Chi2IsThatOfTheModelWhereItEnds) {
  const Problem problem = strong_stribeck();
  const Unknowns unknowns(problem);
  for (const double mu1 : {0.09, 0.105, 0.12})
    for (const double mu2 : {0.03, 0.06}) {
      Residuals residuals(unknowns);
      residuals.set_tolerance(1e-9);
      Eigen::VectorXd start = unknowns.first_guess();
      // The lag is an angle, and ends within half a turn of 0.
      start(0) = mu1, start(1) = mu2, start(2) = mu2 > 0.05 ? -0.1 + 4 * std::numbers::pi : -0.1;
      ASSERT_TRUE(residuals.linearise(start));
      const Minimum minimum = minimise_linearised(residuals, unknowns.z(start));
      Residuals anew(unknowns);
      anew.set_tolerance(1e-9);
      const Eigen::VectorXd there = unknowns.values(minimum.z);
      ASSERT_TRUE(anew.linearise(there));
      EXPECT_NEAR(anew.chi2(there), minimum.chi2, 1e-3 + 1e-3 * minimum.chi2) << mu1 << ", " << mu2;
      EXPECT_LE(std::abs(there(2)), std::numbers::pi);
    }
}

/// The column of the Jacobian at `values`, and differences of the residuals over a step either way.
void expect_derivative(const Residuals& residuals, const Eigen::VectorXd& values, Eigen::Index i, double step,
                       double share) {
  const auto at = [&](const Eigen::VectorXd& there) {
    Residuals anew = residuals;
    EXPECT_TRUE(anew.linearise(there));
    return *anew.at(there);
  };
  Eigen::VectorXd more = values, less = values;
  more(i) += step, less(i) -= step;
  const Eigen::VectorXd differences = (at(more).residuals() - at(less).residuals()) / (2 * step);
  EXPECT_LT((at(values).jacobian(values.size()).col(i) - differences).norm(), share * differences.norm())
      << to_string(residuals.unknowns().parameter(i));
}

/// Near the minimum of strong_stribeck(), under this law.
Eigen::VectorXd values_under(const Unknowns& unknowns, double stribeck) {
  Eigen::VectorXd values = unknowns.first_guess();
  values.head<3>() << 0.105, 0.04, -0.08;
  values(*unknowns.find(FitParameter::stribeck)) = stribeck;
  return values;
}

// Under a strong law, too, derivatives by what is fitted are those of the displacements under it.
TEST(FullModel, DerivativesAreThoseUnderTheLaw) {
  const Problem problem = strong_stribeck();
  const Unknowns unknowns(problem);
  Residuals residuals(unknowns);
  residuals.set_tolerance(1e-9);
  const Eigen::VectorXd values = values_under(unknowns, 0.45);
  for (Eigen::Index i = 0; i < 3; ++i)  // motion jumps elsewhere
    expect_derivative(residuals, values, i, 0.002 * std::abs(values(i)), 0.1);
}

/// Two of its runs, as tracks.
Problem strong_stribeck_of_tracks() {
  Problem problem = strong_stribeck();
  for (const std::size_t k : {std::size_t{1}, std::size_t{6}}) {
    const SummaryRun& summary = problem.summary_runs[k];
    TrajectoryRun run;
    run.scenario = summary.scenario;
    run.track.platform_frame = true;
    for (int i = 0; i <= 150; ++i) {
      run.track.time.push_back(2e-3 * i);
      run.track.position.emplace_back(0, 0);
      run.track.covariance.push_back(1e-11 * Eigen::Matrix2d::Identity());
    }
    problem.trajectory_runs.push_back(run);
  }
  problem.summary_runs.clear();
  problem.conditions.push_back({FitParameter::amplitude, 1e-6, "test"});
  problem.conditions.push_back({FitParameter::angular_frequency, 0.03, "test"});
  problem.conditions.push_back({FitParameter::phase_shift, 0.01, "test"});
  return problem;
}

// Of tracks those by everything that all runs share.
TEST(FullModel, DerivativesOfTracksAreThoseUnderTheLaw) {
  const Problem problem = strong_stribeck_of_tracks();
  const Unknowns unknowns(problem);
  Residuals residuals(unknowns);
  residuals.set_tolerance(1e-10);
  Eigen::VectorXd values = values_under(unknowns, 0.2);
  values(*unknowns.find(FitParameter::gate_edges)) = 0.01;
  const Eigen::VectorXd units = unknowns.natural_units(values);
  for (Eigen::Index i = 0; i < unknowns.common(); ++i)
    expect_derivative(residuals, values, i, 1e-3 * units(i), 0.02);
}

}  // namespace
}  // namespace tribotrack::fit::internal
