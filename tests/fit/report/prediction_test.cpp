#include "fit/prediction.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "fit/campaign.h"
#include "model/trajectory.h"

namespace tribotrack::fit {
namespace {

using test::Truth;

/// mu1, mu2, lag, A and w with correlated errors small enough for first order.
FittedParameters known() {
  FittedParameters known;
  known.parameters = {FitParameter::mu1, FitParameter::mu2, FitParameter::lag, FitParameter::amplitude,
                      FitParameter::angular_frequency};
  const Truth truth;
  known.estimates.resize(5);
  known.estimates << truth.mu1, truth.mu2, truth.lag, 0.28e-3, 62.8;
  Eigen::MatrixXd root = Eigen::MatrixXd::Zero(5, 5);
  root.diagonal() << 1e-5, 2e-6, 1e-4, 1e-8, 1e-3;
  root(1, 0) = 1e-6;
  root(2, 0) = -8e-5;
  root(3, 1) = 5e-9;
  known.covariance = root * root.transpose();
  return known;
}

/// The end of a run when each parameter is moved.
Eigen::Vector2d end_with(model::Scenario s, const Eigen::VectorXd& moved, const Eigen::VectorXd& estimates) {
  s.friction.nominal += moved(0);
  s.friction.reduced += moved(1);
  s.friction.lag += moved(2);
  s.drive.amplitude *= 1 + moved(3) / estimates(3);
  s.drive.amplitude_y *= 1 + moved(3) / estimates(3);
  s.drive.angular_frequency += moved(4);
  return model::integrate(s).end().position;
}

// By differences of whole runs, an independent way.
TEST(Prediction, CovarianceIsThatOfTheEndPoint) {
  const FittedParameters fitted = known();
  for (const model::Scenario& scenario : test::fourteen(Truth{})) {
    const Displacement predicted = predicted_displacement(scenario, fitted);
    EXPECT_NEAR((predicted.vector - model::integrate(scenario).end().position).norm(), 0, 1e-9);
    Eigen::MatrixXd slopes(2, 5);
    for (Eigen::Index k = 0; k < 5; ++k) {
      Eigen::VectorXd step = Eigen::VectorXd::Zero(5);
      step(k) = 1e-4 * fitted.estimates(k);
      slopes.col(k) =
          (end_with(scenario, step, fitted.estimates) - end_with(scenario, -step, fitted.estimates)) /
          (2 * step(k));
    }
    const Eigen::Matrix2d wanted = slopes * fitted.covariance * slopes.transpose();
    EXPECT_LT((predicted.covariance - wanted).norm(), 0.02 * wanted.norm());
    ASSERT_TRUE(predicted.alpha);
    EXPECT_GT(predicted.alpha->sd, 0);
  }
}

TEST(Prediction, IsTheSameWithinALimitAndNoneBeyondIt) {
  const model::Scenario scenario = test::fourteen(Truth{}).front();
  EXPECT_EQ(predicted_displacement(scenario, known(), 100'000).vector,
            predicted_displacement(scenario, known()).vector);
  EXPECT_THROW(predicted_displacement(scenario, known(), 20), model::StepLimitExceeded);
}

}  // namespace
}  // namespace tribotrack::fit
