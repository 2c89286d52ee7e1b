#include "fit/slides/between_slides.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "fit/estimate.h"
#include "fit/free_slides.h"
#include "fit/tools/statistics.h"

namespace tribotrack::fit {
namespace {

using internal::between_slides;
using internal::BetweenSlides;
using testing::HasSubstr;

TEST(BetweenSlides, IsTheSampleSdWhereErrorsAreNegligible) {
  const BetweenSlides b = between_slides({{1, 1e-9}, {2, 1e-9}, {4, 1e-9}});
  EXPECT_NEAR(b.mean, 7.0 / 3, 1e-9);
  EXPECT_NEAR(b.sd, std::sqrt(7.0 / 3), 1e-8);
  EXPECT_NEAR(1 / std::sqrt(b.information), std::sqrt(7.0 / 9), 1e-8);
  EXPECT_EQ(b.dof, 2);
}

TEST(BetweenSlides, IsNothingWhereErrorsExplainAll) {
  const BetweenSlides b = between_slides({{1, 1}, {1.5, 1}, {0.7, 2}});
  EXPECT_EQ(b.sd, 0);
  EXPECT_NEAR(1 / std::sqrt(b.information), 1 / std::sqrt(2.25), 1e-15);
  EXPECT_GT(b.p_value, 0.5);
}

TEST(BetweenSlides, SolvesPauleAndMandelsEquation) {
  const std::vector<Estimate> slides = {{0.148, 0.002}, {0.171, 0.004}, {0.204, 0.003}, {0.165, 0.01}};
  const BetweenSlides b = between_slides(slides);
  double sum = 0, information = 0, weighted = 0;
  for (const Estimate& s : slides) {
    const double w = 1 / (s.sd * s.sd + b.sd * b.sd);
    sum += w * std::pow(s.value - b.mean, 2);
    information += w;
    weighted += w * s.value;
  }
  EXPECT_NEAR(sum, 3, 1e-9);
  EXPECT_NEAR(weighted / information, b.mean, 1e-12);
  EXPECT_NEAR(information, b.information, 1e-6 * information);
  EXPECT_LT(b.p_value, 1e-10);
}

TEST(BetweenSlides, IntervalsOfTheMeanHold) {
  // Five slides, a scatter of none, one and five times their own errors.
  std::mt19937 random(11);
  std::normal_distribution<double> normal;
  for (const double scatter : {0.0, 1.0, 5.0}) {
    int inside = 0;
    constexpr int kRounds = 2000;
    for (int round = 0; round < kRounds; ++round) {
      std::vector<Estimate> slides;
      for (int i = 0; i < 5; ++i) {
        const double sd = 0.6 + 0.2 * i;
        slides.push_back({10 + scatter * normal(random) + sd * normal(random), sd});
      }
      const BetweenSlides b = between_slides(slides);
      inside += std::abs(b.mean - 10) < internal::two_sided_quantile(0.95, b.dof) / std::sqrt(b.information);
    }
    EXPECT_GT(inside, 0.935 * kRounds) << scatter;
    EXPECT_LT(inside, (scatter > 2 ? 0.965 : 1.0) * kRounds) << scatter;
  }
}

std::vector<TrajectoryRun> slides_of(const std::vector<double>& mu, unsigned seed) {
  std::mt19937 random(seed);
  const test::UnitSlide motion(0);
  std::vector<TrajectoryRun> runs;
  for (std::size_t i = 0; i < mu.size(); ++i) {
    test::SlideLook look;
    look.mu = mu[i];
    look.angle = 0.7 * static_cast<double>(i);
    runs.push_back(test::slide_track(motion, 0, look, random, false));
    runs.back().name = "man " + std::to_string(i + 1);
  }
  return runs;
}

FitOptions quick() {
  return {.multi_starts = 1, .profiles = false, .next_experiment = false};
}

TEST(BetweenSlides, PooledMeanCountsTheScatter) {
  const std::vector<double> mu = {0.148, 0.160, 0.204, 0.171, 0.180};
  Problem problem;
  problem.free = {FitParameter::mu1};
  problem.trajectory_runs = slides_of(mu, 12);
  FitOptions options = quick();
  options.profiles = true;
  const FitResult fit = estimate(problem, options);
  ASSERT_EQ(fit.slides.size(), mu.size());
  std::vector<Estimate> one_by_one;
  for (std::size_t i = 0; i < mu.size(); ++i) {
    EXPECT_NEAR(fit.slides[i].mu1.value, mu[i], 4 * fit.slides[i].mu1.sd);
    EXPECT_GT(fit.slides[i].p_value, 1e-3);
    one_by_one.push_back(fit.slides[i].mu1);
  }
  const BetweenSlides b = between_slides(one_by_one);
  const ParameterEstimate& mean = fit.parameters.front();
  EXPECT_NEAR(mean.estimate, b.mean, 1e-5);
  EXPECT_NEAR(mean.sd, 1 / std::sqrt(b.information), 0.01 * mean.sd);
  EXPECT_NEAR(fit.between_slides.sd, 0.0213, 0.002);  // the sample's
  const double reach = internal::two_sided_quantile(0.95, 4) * mean.sd / mean.estimate;
  EXPECT_NEAR(std::log(mean.ci95.high / mean.estimate), reach, 1e-3);
  EXPECT_NEAR(mean.profile_ci95.high, mean.ci95.high, 0.1 * (mean.ci95.high - mean.estimate));
  ASSERT_FALSE(fit.warnings.empty());
  EXPECT_THAT(fit.warnings.back(), HasSubstr("mu1 differs from slide to slide by more than chance"));
  EXPECT_THAT(fit.warnings.back(), HasSubstr("'man 1'"));
  EXPECT_THAT(fit.covariance_meaning, HasSubstr("Hartung and Knapp"));
  EXPECT_GT(fit.p_value, 1e-3) << "each slide by itself agrees with constant friction";
}

TEST(BetweenSlides, SlidesThatAgreeAreNotWarnedOf) {
  Problem problem;
  problem.free = {FitParameter::mu1};
  problem.trajectory_runs = slides_of({0.17, 0.17, 0.17, 0.17}, 13);
  const FitResult fit = estimate(problem, quick());
  EXPECT_GT(fit.between_slides.p_value, 0.05);
  EXPECT_TRUE(fit.warnings.empty()) << fit.warnings.front();
  EXPECT_LT(fit.parameters.front().ci95.low, 0.17);
  EXPECT_GT(fit.parameters.front().ci95.high, 0.17);
}

}  // namespace
}  // namespace tribotrack::fit
