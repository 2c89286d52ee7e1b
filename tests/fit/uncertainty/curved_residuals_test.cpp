// The second order about a minimum, and the refits that rest on it.
#include "fit/uncertainty/curved_residuals.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <random>

#include "apps/bench/fit/bench.h"
#include "fit/uncertainty/displacement_refits.h"

namespace tribotrack::fit {
namespace {

using namespace internal;

struct Fitted {
  explicit Fitted(Problem given) : problem(std::move(given)), unknowns(problem), residuals(unknowns) {
    residuals.set_tolerance(1e-10);
    best = minimise(residuals, unknowns.z(unknowns.first_guess()));
  }
  Problem problem;
  Unknowns unknowns;
  Residuals residuals;
  Minimum best;
};

Problem campaign() {
  Problem problem = bench::simulated_campaign({0.1, 0.0125, 0.15}, 17);
  problem.prior[FitParameter::mu2] = {0.012, 0.002};
  return problem;
}

/// Along every axis the residuals agree to third order: half as far, an eighth of the difference.
TEST(CurvedResiduals, AgreeToSecondOrder) {
  const Fitted fitted(campaign());
  ASSERT_TRUE(fitted.best.converged);
  const auto curved = CurvedResiduals::about(fitted.residuals, fitted.best, 1);
  ASSERT_TRUE(curved);
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const auto off = [&](double far) {
      const Eigen::VectorXd t = far * Eigen::VectorXd::Unit(3, axis);
      Eigen::VectorXd r;
      EXPECT_TRUE(fitted.residuals.evaluate(fitted.unknowns.values(curved->z(t)), r, nullptr));
      EXPECT_NEAR((r - fitted.best.residuals).norm(), std::abs(far), 0.2 * std::abs(far));
      return (r - curved->at(fitted.best.residuals, t)).norm();
    };
    EXPECT_LT(off(0.5), 5e-3);
    EXPECT_LT(off(2), 80 * off(0.5) + 1e-4);
  }
  const auto at_best = curved->minimum(fitted.best.residuals);
  ASSERT_TRUE(at_best);
  EXPECT_LT(at_best->norm(), 1e-3);
}

/// Every refit reported as found is where a descent on the same data ends, and nearly all are.
TEST(CurvedResiduals, RefitsAreThoseOfDescents) {
  const Fitted fitted(campaign());
  const auto curved = CurvedResiduals::about(fitted.residuals, fitted.best, 1);
  ASSERT_TRUE(curved);
  std::mt19937_64 random(5);
  std::cout << "seed 5\n";
  std::normal_distribution<double> normal;
  std::vector<Problem> drawn(40, fitted.problem);
  for (Problem& problem : drawn) {
    for (std::size_t i = 0; i < problem.summary_runs.size(); ++i) {
      auto& measured = problem.summary_runs[i].measured;
      measured.vector -= fitted.residuals.difference(fitted.best.residuals, i);
      const Eigen::LLT<Eigen::Matrix2d> factor(fitted.residuals.covariance(i));
      measured.vector += factor.matrixL() * Eigen::Vector2d(normal(random), normal(random));
    }
    problem.prior.at(FitParameter::mu2).mean += 0.002 * normal(random);
  }
  const auto refits = refit_displacements(fitted.residuals, fitted.best, *curved, drawn, 2);
  const Eigen::MatrixXd by_z = fitted.best.jacobian * fitted.unknowns.slopes(fitted.best.z).asDiagonal();
  int found = 0;
  for (std::size_t k = 0; k < drawn.size(); ++k) {
    if (!refits[k].found) continue;
    ++found;
    const Unknowns own(drawn[k]);
    Residuals exact(own);
    exact.set_tolerance(1e-10);
    const Minimum minimum = minimise(exact, fitted.best.z);
    ASSERT_TRUE(minimum.converged);
    EXPECT_LT((by_z * (refits[k].z - minimum.z)).norm(), 0.03) << k;  // standard deviations
    EXPECT_LT(exact.chi2(own.values(refits[k].z)), minimum.chi2 + 1e-3) << k;
  }
  EXPECT_GE(found, 34);
}

/// A direction the data do not see has no second order worth the name.
TEST(CurvedResiduals, NoneWithAFlatDirection) {
  const Fitted fitted(bench::simulated_campaign({0.1, 0.0125, 0.15}, 17));
  Minimum flat = fitted.best;
  flat.jacobian.col(1).setZero();
  EXPECT_FALSE(CurvedResiduals::about(fitted.residuals, flat, 1));
}

}  // namespace
}  // namespace tribotrack::fit
