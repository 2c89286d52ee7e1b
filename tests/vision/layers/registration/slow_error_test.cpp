#include "vision/layers/registration/slow_error.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <random>

namespace tribotrack::vision {
namespace {

constexpr int kPlaces = 24;

/// Flat frames: every place is known equally well.
GroundPicture flat_ground() {
  GroundPicture ground({0, 0, kPlaces, kPlaces});
  for (int k = 0; k < 5; ++k) ground.add(Picture(kPlaces, kPlaces, 70), 0, 0, {}, {-50, -50, 1});
  ground.finish(2);
  return ground;
}

struct Problem {
  std::vector<GroundLean> windows;
  Eigen::MatrixXd joint;  ///< normal equations of all positions, then all places

  /// Windows that lean on `shared` places each, of a row of them.
  Problem(const GroundPicture& ground, int count, int shared, unsigned seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> gauss;
    const Eigen::Index n = 2 * count, all = n + kPlaces;
    joint = Eigen::MatrixXd::Zero(all, all);
    const double v = ground.variance().at(kPlaces / 2, kPlaces / 2);
    for (Eigen::Index place = n; place < all; ++place) joint(place, place) = 1 / v;
    for (int k = 0; k < count; ++k) {
      GroundLean w;
      w.frame = 5 * k;
      Eigen::Matrix2d own = 40 * Eigen::Matrix2d::Identity();
      own(0, 1) = own(1, 0) = 6;
      joint.block<2, 2>(2 * k, 2 * k) = own;
      for (int i = 0; i < shared; ++i) {
        const int column = (k + i) % kPlaces, row = kPlaces / 2;
        const Eigen::Vector2d a(gauss(random), gauss(random));
        w.pulls.push_back({static_cast<std::uint32_t>(row * kPlaces + column), static_cast<float>(a.x()),
                           static_cast<float>(a.y())});
        joint.block<2, 1>(2 * k, n + column) += a;
        joint.block<1, 2>(n + column, 2 * k) += a.transpose();
        own -= v * a * a.transpose();
      }
      w.information = own;
      windows.push_back(w);
    }
  }
};

/// Half the trace per window of a covariance, the mean of the windows taken out.
double variance(const Eigen::MatrixXd& covariance) {
  const Eigen::Index n = covariance.rows();
  Eigen::MatrixXd out = Eigen::MatrixXd::Identity(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = i % 2; j < n; j += 2) out(i, j) -= 2.0 / static_cast<double>(n);
  return (out * covariance * out.transpose()).trace() / static_cast<double>(n);
}

TEST(SlowError, IsWhatUnknownPlacesAddToPositionsInTheJointProblem) {
  constexpr unsigned kSeed = 3;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  const GroundPicture ground = flat_ground();
  const Problem p(ground, 12, 5, kSeed);
  const Eigen::MatrixXd known = p.joint.topLeftCorner(24, 24).inverse();
  const Eigen::MatrixXd unknown = p.joint.inverse().topLeftCorner(24, 24);
  const SlowError slow = slow_error(p.windows, ground);
  EXPECT_GT(slow.sd, 0);
  EXPECT_NEAR(slow.sd * slow.sd, variance(unknown - known), 1e-4 * variance(unknown));
}

TEST(SlowError, IsNothingWhereNoPlaceIsShared) {
  const GroundPicture ground = flat_ground();
  const Problem p(ground, 12, 0, 4);
  const SlowError slow = slow_error(p.windows, ground);
  EXPECT_EQ(slow.sd, 0);
  EXPECT_EQ(slow.frames, 0);
  EXPECT_EQ(slow.widening, 1);
}

TEST(SlowError, ManyPairsAreThinnedWithoutBias) {
  // More windows and places than are summed in full: against the sum in full, by the joint problem.
  const GroundPicture ground = flat_ground();
  const Problem few(ground, 120, 24, 5);
  std::vector<GroundLean> many = few.windows;
  // The same pulls on 24 rows at once, each a 24th of the information: pairs 24 times as many.
  for (GroundLean& w : many) {
    std::vector<GroundLean::Pull> rows;
    for (const GroundLean::Pull& pull : w.pulls)
      for (std::uint32_t row = 0; row < kPlaces; ++row)
        rows.push_back(
            {row * kPlaces + pull.place % kPlaces, pull.x / std::sqrt(24.0F), pull.y / std::sqrt(24.0F)});
    w.pulls = rows;
  }
  const SlowError a = slow_error(few.windows, ground), b = slow_error(many, ground);
  EXPECT_NEAR(a.sd, b.sd, 0.05 * a.sd);
}

}  // namespace
}  // namespace tribotrack::vision
