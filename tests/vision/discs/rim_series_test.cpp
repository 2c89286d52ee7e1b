#include "vision/discs/rim_series.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <cstdio>
#include <random>

namespace tribotrack::vision {
namespace {

/// A rim whose sectors stray by `pattern` and by what is drawn.
RimSectors rim_at(const Point& centre, double pattern, double scatter, std::mt19937& random) {
  constexpr int kSectors = 40;
  std::normal_distribution<double> normal;
  RimSectors rim;
  rim.circle = {centre.x, centre.y, 30};
  for (int k = 0; k < kSectors; ++k) {
    const Point u = sector_direction(k, kSectors);
    rim.deviation.push_back(
        static_cast<float>(pattern * std::cos(3 * std::atan2(u.y, u.x)) + scatter * normal(random)));
    rim.information.push_back(100);
  }
  return rim;
}

TEST(RimSeries, CentresScatterAsTheySayWhateverBelongsToTheDisc) {
  std::mt19937 random(7);
  std::normal_distribution<double> place(0, 0.2);
  for (const double pattern : {0.0, 0.3})
    for (const double scatter : {0.02, 0.1}) {
      std::vector<RimFrame> frames;
      std::vector<Point> truth;
      for (int k = 0; k < 200; ++k) {
        truth.push_back({place(random), place(random)});
        frames.push_back({k, rim_at(truth.back(), pattern, scatter, random)});
      }
      const auto fixes = fix_centres(frames, 1e-6);
      double squares = 0, rms = 0;
      for (std::size_t k = 0; k < fixes.size(); ++k) {
        const Eigen::Vector2d e(fixes[k].centre.x - truth[k].x, fixes[k].centre.y - truth[k].y);
        squares += e.dot(fixes[k].covariance.inverse() * e) / 400;
        rms += e.squaredNorm() / 400;
      }
      std::printf("pattern %g, scatter %g: rms %.4f px, standardised %.3f\n", pattern, scatter,
                  std::sqrt(rms), std::sqrt(squares));
      EXPECT_NEAR(std::sqrt(rms), scatter * std::sqrt(2.0 / 40), 0.12 * scatter * std::sqrt(2.0 / 40));
      EXPECT_NEAR(std::sqrt(squares), 1, 0.12);  // 400 components scatter by 3.5 %
    }
}

TEST(RimSeries, AFewSectorsFarOffChangeNothing) {
  std::mt19937 random(8);
  std::vector<RimFrame> frames;
  for (int k = 0; k < 40; ++k) frames.push_back({k, rim_at({0, 0}, 0, 0.02, random)});
  const Point before = fix_centres(frames, 1e-6)[20].centre;
  frames[20].rim.deviation[3] += 1.5F;
  frames[20].rim.deviation[4] += 1.5F;
  const Point after = fix_centres(frames, 1e-6)[20].centre;
  EXPECT_NEAR(after.x, before.x, 0.004);
  EXPECT_NEAR(after.y, before.y, 0.004);
}

TEST(RimSeries, IsNeverSurerThanTheNoiseAllows) {
  std::mt19937 random(9);
  std::vector<RimFrame> frames;
  for (int k = 0; k < 20; ++k) frames.push_back({k, rim_at({0, 0}, 0, 0, random)});  // a coder repeats itself
  const auto fix = fix_centres(frames, 4.0)[10];
  EXPECT_NEAR(fix.covariance(0, 0), 2.0 / 40 * 4.0 / 100, 1e-6);
}

TEST(RimSeries, FramesMustHaveTheSameSectors) {
  std::mt19937 random(10);
  std::vector<RimFrame> frames{{0, rim_at({0, 0}, 0, 0.1, random)}, {1, rim_at({0, 0}, 0, 0.1, random)}};
  frames[1].rim.deviation.pop_back();
  EXPECT_THROW(fix_centres(frames, 1), std::invalid_argument);
  EXPECT_TRUE(fix_centres({}, 1).empty());
}

}  // namespace
}  // namespace tribotrack::vision
