// Bands of time, and the variances of fields along rays.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <random>
#include <vector>

#include "vision/edge/rays.h"

namespace tribotrack::vision {
namespace {

TEST(Bands, AddUpToTheSeriesAndShareWhiteNoiseAsStated) {
  constexpr std::size_t kRows = 600, kWidth = 40;
  std::mt19937 random(3);
  std::normal_distribution<float> noise;
  std::vector<float> series(kRows * kWidth);
  for (float& v : series) v = noise(random);
  const std::size_t ends[] = {200, 600};
  const Bands bands = split_bands(series, kWidth, ends);
  const std::array<double, kBands> shares = noise_shares(ends);
  std::array<double, kBands> squares{};
  for (std::size_t i = 0; i < series.size(); ++i) {
    EXPECT_NEAR(bands[0][i] + bands[1][i] + bands[2][i], series[i], 1e-5);
    for (std::size_t b = 0; b < kBands; ++b) squares[b] += static_cast<double>(bands[b][i]) * bands[b][i];
  }
  for (std::size_t b = 0; b < kBands; ++b)
    EXPECT_NEAR(squares[b] / static_cast<double>(series.size()), shares[b], 0.1 * shares[b]) << b;
}

TEST(RayFields, EndAtTheEdgeAndBeginThere) {
  const RayGrid grid = ray_grid(30);
  const RimOptics rim{0, 0.5, 2};
  const std::vector<Eigen::MatrixXd> fields = RayFields(grid).covariances(rim, RayFields::Beside::nothing);
  for (std::size_t s = 0; s < grid.places(); ++s) {
    const double off = grid.offset(s);
    const auto at = static_cast<Eigen::Index>(s);
    const double top = fields[0](at, at), outside = fields[3](at, at), chamfer = fields[6](at, at);
    EXPECT_TRUE(off < 3 || top < 1e-6) << off;
    EXPECT_TRUE(off > -3 || outside < 1e-6) << off;
    EXPECT_TRUE(off > -4 || fields[2](at, at) > 0.95) << off;  // blur leaves a long field what it is
    EXPECT_TRUE(std::abs(off + 1) < 4 || chamfer < 1e-6) << off;
  }
  EXPECT_NEAR(fields[6](grid.inside - 1, grid.inside - 1), std::pow(std::erf(1 / (0.5 * std::sqrt(2.0))), 2),
              0.02);
}

/// Drawn from fields of known variance, in noise.
TEST(RayFields, VariancesAreThoseOfGreatestLikelihood) {
  const std::vector<Eigen::MatrixXd> fields =
      RayFields(ray_grid(30)).covariances({0, 0.8, 1}, RayFields::Beside::nothing);
  Eigen::VectorXd drawn = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(fields.size()));
  drawn(1) = 40;
  drawn(4) = 15;
  Eigen::MatrixXd covariance = field_covariance(fields, drawn);
  covariance.diagonal().array() += 1;  // noise
  Eigen::VectorXd found;
  fit_variances(covariance, fields, 1, 3000, found);
  EXPECT_NEAR(found(1), 40, 2);
  EXPECT_NEAR(found(4), 15, 1);
  EXPECT_LT(found.sum() - found(1) - found(4), 2.5);
  // Any other edge is less likely.
  const auto cost = [&](double edge) {
    Eigen::VectorXd v;
    return fit_variances(covariance,
                         RayFields(ray_grid(30)).covariances({edge, 0.8, 1}, RayFields::Beside::nothing), 1,
                         300, v);
  };
  EXPECT_LT(cost(0), cost(0.5));
  EXPECT_LT(cost(0), cost(-0.5));
}

}  // namespace
}  // namespace tribotrack::vision
