// Correlated errors: whitening and restricted likelihood against dense matrices of all points.
#include "fit/residuals/track_whitening.h"
#include "fit/tools/dense.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>
#include <numbers>
#include <random>

#include "fit/campaign.h"
#include "fit/design/forecast.h"
#include "fit/estimate.h"
#include "fit/slow_tracks.h"
#include "fit/variances/correlated_variances.h"

namespace tribotrack::fit::internal {
namespace {

constexpr double pi = std::numbers::pi;

std::vector<double> times_of(int n, double rate) {
  std::vector<double> times;
  for (int k = 0; k < n; ++k) times.push_back(k / rate);
  return times;
}

// Points whose axes are correlated and unequal.
std::vector<Eigen::Matrix2d> covariances_of(int n, std::mt19937& random) {
  std::uniform_real_distribution<double> sigma(0.5, 2);
  std::vector<Eigen::Matrix2d> covariances;
  for (int k = 0; k < n; ++k) {
    const double a = sigma(random), b = sigma(random);
    covariances.push_back((Eigen::Matrix2d() << a * a, 0.3 * a * b, 0.3 * a * b, b * b).finished());
  }
  return covariances;
}

// Without a limit on modes: sum of products of Karhunen-Loeve modes = min(s, t).
TEST(CorrelatedErrors, TheWalksModesAreThoseOfBrownianMotion) {
  const auto times = times_of(200, 100);
  const ErrorShapes shapes = error_shapes(times, 0, 0, times.back(), {false, true});
  ASSERT_EQ(shapes.count(), kWalkModes);
  const Eigen::MatrixXd covariance = shapes.values * shapes.values.transpose();
  const double tail = 1 / (pi * pi * static_cast<double>(kWalkModes));  // of the variance at the end
  for (const int i : {20, 100, 199})
    for (const int j : {5, 100, 199})
      EXPECT_NEAR(covariance(i, j), std::min(i, j) / 199.0, 2.5 * tail) << i << " " << j;
}

TEST(CorrelatedErrors, WhiteningIsThatOfTheDenseCovariance) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  const int n = 90;
  const auto times = times_of(n, 100);
  const ErrorShapes shapes = error_shapes(times, 30, 0.4, 1.7, kAllParts);
  const std::vector<Eigen::Matrix2d> covariances = covariances_of(n, random);
  const PointWhitening points(times, covariances, std::vector<double>(n, 1), {});
  const Eigen::MatrixX2d white = points.shift();
  const CorrelatedVariances variances{3, 0.5, 0.1, 20};
  const CorrelatedWhitening whitening(whitened_columns(error_columns(shapes), points, orthonormal(white)),
                                      column_variances(shapes, variances));

  // V of the points as they are; the start point projected out by its normal equations under V.
  const auto rows = static_cast<Eigen::Index>(2 * n);
  Eigen::MatrixXd u = Eigen::MatrixXd::Zero(rows, static_cast<Eigen::Index>(2 * shapes.count()));
  Eigen::VectorXd g(u.cols());
  for (Eigen::Index j = 0; j < u.cols(); ++j) {
    for (Eigen::Index k = 0; k < n; ++k) u(2 * k + j % 2, j) = shapes.values(k, j / 2);
    g(j) = variances[shapes.part[static_cast<std::size_t>(j / 2)]];
  }
  Eigen::MatrixXd v = u * g.asDiagonal() * u.transpose();
  Eigen::MatrixXd start(rows, 2);
  for (Eigen::Index k = 0; k < n; ++k) {
    const Eigen::Matrix2d factor = white.middleRows<2>(2 * k);
    v.block<2, 2>(2 * k, 2 * k) += (factor.transpose() * factor).inverse();
    start.middleRows<2>(2 * k).setIdentity();
  }
  const Eigen::LLT<Eigen::MatrixXd> dense(v);
  const Eigen::MatrixXd v_start = dense.solve(start);
  Eigen::MatrixXd data(rows, 3);
  for (auto& value : data.reshaped()) value = normal(random);
  const Eigen::MatrixXd v_data = dense.solve(data), crossed = start.transpose() * v_data;
  const Eigen::MatrixXd expected =
      data.transpose() * v_data -
      crossed.transpose() * Eigen::MatrixXd(start.transpose() * v_start).ldlt().solve(crossed);

  Eigen::MatrixXd whitened(rows, 3);
  for (Eigen::Index k = 0; k < n; ++k)
    whitened.middleRows<2>(2 * k) = white.middleRows<2>(2 * k) * data.middleRows<2>(2 * k);
  const Eigen::MatrixXd normal_start = white.transpose() * white;
  whitened -= white * normal_start.ldlt().solve(white.transpose() * whitened).eval();
  for (Eigen::Index j = 0; j < 3; ++j) whitening.apply(whitened.col(j));
  EXPECT_LT((whitened.transpose() * whitened - expected).norm(), 1e-10 * expected.norm());
}

// ln |V| + ln |X' V^-1 X| + r' P r by dense matrices, start points among the unknowns: no neighbour of the
// variances found is more likely, and the sds are those of its curvature.
TEST(CorrelatedErrors, VariancesAreTheMostLikely) {
  std::mt19937 random(12);
  Problem problem;
  problem.free = {FitParameter::mu1, FitParameter::mu2, FitParameter::lag};
  const test::SlowTruth slow{.drift = 2e-6, .walk = 1e-6, .circle = 1e-6, .overtones = 0.7e-6};
  for (int k = 0; k < 3; ++k)
    problem.trajectory_runs.push_back(
        test::slow_track(test::scenario({}, 2.0 * k, 0.8 + 0.3 * k, 3), 200, 0.5e-6, slow, random));
  const Unknowns unknowns(problem);
  Residuals residuals(unknowns);
  const Eigen::Vector3d truth(0.1, 0.0125, 0.1);
  const CorrelatedEstimate found = estimate_correlated_errors(residuals, truth);
  int present = 0;
  for (const double variance : found.variances) present += variance > 0;
  ASSERT_GE(present, 3);

  const auto before = residuals.at(truth);
  ASSERT_TRUE(before);
  const Eigen::VectorXd r = before->residuals();
  const Eigen::MatrixXd jacobian = before->jacobian(3);
  struct Dense {
    Eigen::MatrixXd v, x;
  };
  const auto dense = [&](const CorrelatedVariances& variances) {
    Eigen::MatrixXd v = Eigen::MatrixXd::Identity(r.size(), r.size());
    Eigen::MatrixXd x(r.size(), 3 + 6);
    x.leftCols(3) = jacobian * unknowns.natural_units(truth).asDiagonal();
    x.rightCols(6).setZero();
    for (std::size_t i = 0; i < 3; ++i) {
      const Eigen::MatrixX2d white = residuals.track(i).white();
      const ErrorShapes shapes = residuals.track(i).shapes(kAllParts);
      const auto row = static_cast<Eigen::Index>(i) * white.rows();
      x.block(row, 3 + 2 * static_cast<Eigen::Index>(i), white.rows(), 2) = white / white.norm();
      for (std::size_t j = 0; j < shapes.count(); ++j)
        for (Eigen::Index axis = 0; axis < 2; ++axis) {
          Eigen::VectorXd u = white.col(axis);
          for (Eigen::Index k = 0; k < u.size(); ++k)
            u(k) *= shapes.values(k / 2, static_cast<Eigen::Index>(j));
          v.block(row, row, u.size(), u.size()) += variances[shapes.part[j]] * u * u.transpose();
        }
    }
    return Dense{v, x};
  };
  const auto likelihood = [&](const CorrelatedVariances& variances) {
    const auto [v, x] = dense(variances);
    const Eigen::LLT<Eigen::MatrixXd> factor(v);
    const Eigen::MatrixXd solved = factor.solve(x), information = x.transpose() * solved;
    const Eigen::VectorXd across = solved.transpose() * r;
    return -factor.matrixLLT().diagonal().array().log().sum() -
           0.5 * (std::log(information.determinant()) + r.dot(factor.solve(r)) -
                  across.dot(information.ldlt().solve(across)));
  };
  const double best = likelihood(found.variances);
  for (std::size_t part = 0; part < kErrorParts; ++part) {
    if (!(found.variances[part] > 0)) continue;
    for (const double step : {-0.1, 0.1}) {
      CorrelatedVariances moved = found.variances;
      moved[part] *= 1 + step;
      EXPECT_LT(likelihood(moved), best + 1e-3) << "part " << part << " step " << step;
    }
  }
}

// The forecast of a track like an existing one has the information of that one.
TEST(CorrelatedErrors, AForecastCountsThem) {
  std::mt19937 random(6);
  Problem problem;
  problem.free = {FitParameter::mu1, FitParameter::mu2, FitParameter::lag};
  const model::Scenario scenario = test::scenario({}, 1, 1.2, 20);
  problem.trajectory_runs = {test::slow_track(scenario, 250, 0.5e-6, {}, random)};
  const Unknowns unknowns(problem);
  Residuals residuals(unknowns);
  const Eigen::Vector3d truth(0.1, 0.0125, 0.1);
  ExcessVariance scatter = residuals.excess_variance();
  double without = 0;
  for (const bool slow : {false, true}) {
    if (slow) scatter.correlated = {1e-12, 0.3e-12, 0.1e-12, 0.05e-12};
    residuals.set_excess_variance(scatter);
    const auto at = residuals.at(truth);
    ASSERT_TRUE(at);
    const Eigen::MatrixXd told = at->scaled(unknowns.natural_units(truth)).normal();
    const auto& drive = scenario.drive;
    const auto forecast =
        Forecaster(residuals, truth).forecast({1, 1.2, drive.amplitude, drive.angular_frequency}, 1e-10);
    ASSERT_FALSE(forecast.empty());
    for (Eigen::Index i = 0; i < 3; ++i)
      EXPECT_NEAR(forecast.information(i, i), told(i, i), 0.05 * told(i, i)) << i;
    if (slow) {
      EXPECT_LT(told(0, 0), 0.5 * without);
    }
    without = told(0, 0);
  }
}

}  // namespace
}  // namespace tribotrack::fit::internal
