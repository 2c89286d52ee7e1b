// mu1 from slides that spin, made by brute force.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <map>

#include "fit/estimate.h"
#include "fit/free_slides.h"

namespace tribotrack::fit {
namespace {

using test::slide_track;
using test::SlideLook;
using test::UnitSlide;

const FitOptions kQuick{.multi_starts = 1, .profiles = false, .next_experiment = false};

FitResult fit_of(const std::vector<TrajectoryRun>& runs, const FitOptions& options = kQuick) {
  Problem problem;
  problem.free = {FitParameter::mu1};
  problem.trajectory_runs = runs;
  return estimate(problem, options);
}

/// The motion of each ratio is integrated once.
const UnitSlide& motion_of(double ratio) {
  static std::map<double, UnitSlide> known;
  return known.try_emplace(ratio, ratio).first->second;
}

TEST(SpinningSlideFit, FindsMuAtAnySpin) {
  for (const double ratio : {0.0, 1.0, 2.0})
    for (const unsigned seed : {1u, 2u, 3u}) {
      SCOPED_TRACE(testing::Message() << "ratio " << ratio << " seed " << seed);
      std::mt19937 random(seed);
      const FitResult fit = fit_of({slide_track(motion_of(ratio), ratio, {}, random)});
      ASSERT_EQ(fit.slides.size(), 1u);
      const SlideResult& slide = fit.slides.front();
      EXPECT_TRUE(slide.spin_seen);
      EXPECT_NEAR(slide.spin_ratio.value, ratio, 4 * slide.spin_ratio.sd + 1e-3);
      EXPECT_LT(slide.mu1.sd, 0.002);
      // Spin and bearing are found at the friction found: their share in its error is not in the sd.
      EXPECT_NEAR(slide.mu1.value, 0.17, 4 * slide.mu1.sd);
      EXPECT_LT(slide.ci95.low, slide.mu1.value);
      EXPECT_GT(fit.p_value, 1e-3) << fit.full_report();
    }
}

using Noise = std::function<double()>;

Noise standard_noise(unsigned seed) {
  return [random = std::mt19937(seed), normal = std::normal_distribution<double>()]() mutable {
    return normal(random);
  };
}

/// Slides of 0.7 m/s and less, whose way in the time t from this speed is `way`(t, speed).
std::vector<TrajectoryRun> slides_along(const std::function<double(double, double)>& way,
                                        const Noise& noise) {
  std::vector<TrajectoryRun> runs;
  for (int k = 0; k < 8; ++k) {
    TrajectoryRun run;
    run.name = "slide" + std::to_string(k);
    run.free_slide = true;
    run.scenario.drive.amplitude = run.scenario.drive.amplitude_y = 0;
    for (int i = 0; i < 60; ++i) {
      const double t = i / 200.0, x = way(t, 0.7 - 0.04 * k);
      run.track.frame.push_back(i);
      run.track.time.push_back(t);
      run.track.position.emplace_back(x + 3e-5 * noise(), 3e-5 * noise());
      run.track.covariance.push_back(9e-10 * Eigen::Matrix2d::Identity());
    }
    runs.push_back(run);
  }
  return runs;
}

/// Under mu g + c v, each with its own c about `viscous`.
std::vector<TrajectoryRun> viscous_slides(double viscous, double between, unsigned seed) {
  const Noise noise = standard_noise(seed);
  std::map<double, double> strength;
  const auto way = [&](double t, double speed) {
    if (!strength.contains(speed)) strength[speed] = viscous + between * noise();
    const double c = strength[speed], a = 0.19 * 9.81;
    const double s = std::min(t, c == 0 ? speed / a : std::log(1 + c * speed / a) / c);
    return c == 0 ? speed * s - a * s * s / 2 : (speed + a / c) * (1 - std::exp(-c * s)) / c - a * s / c;
  };
  return slides_along(way, noise);
}

/// Under mu g (1 + strength exp(-(v/fading)^2)), by steps of the midpoint rule.
std::vector<TrajectoryRun> stribeck_slides(double strength, double fading, unsigned seed) {
  const auto braking = [&](double v) {
    return 0.19 * 9.81 * (1 + strength * std::exp(-v * v / (fading * fading)));
  };
  const auto way = [&](double t, double v) {
    constexpr int kSteps = 2000;
    const double h = t / kSteps;
    double x = 0;
    for (int i = 0; i < kSteps; ++i) {
      const double next = std::max(0.0, v - h * braking(v - 0.5 * h * braking(v)));
      x += 0.5 * h * (v + next);
      v = next;
    }
    return x;
  };
  return slides_along(way, standard_noise(seed));
}

/// Whether one of the explanations that the values hold under is this.
bool holds_under(const FitResult& fit, const std::string& name) {
  return std::ranges::any_of(fit.explanations, [&](const auto& e) { return e.name == name && e.explains; });
}

TEST(SpinningSlideFit, WithoutTheAngleASpinOrAViscousFrictionExplainsAFallingDeceleration) {
  for (const unsigned seed : {4u, 5u, 6u}) {
    std::mt19937 random(seed);
    const FitOptions profiled{.next_experiment = false};
    const FitResult spinning = fit_of({slide_track(motion_of(1.0), 1.0, {}, random, false)}, profiled);
    const FitResult viscous = fit_of({viscous_slides(0.84, 0, seed).front()}, profiled);
    for (const auto& [fit, mu1] : {std::pair(spinning, 0.17), std::pair(viscous, 0.19)}) {
      EXPECT_EQ(fit.verdict, Use::care);
      EXPECT_LT(fit.p_value, 1e-3);
      EXPECT_TRUE(holds_under(fit, "unseen_spin") || holds_under(fit, "viscous")) << fit.full_report();
      EXPECT_LT(fit.parameters.front().ci95.low, mu1) << fit.full_report();
      EXPECT_GT(fit.parameters.front().ci95.high, mu1) << fit.full_report();
    }
  }
}

TEST(SpinningSlideFit, TheIntervalOfSlidesThatSpinDifferentlyCoversSpinAndViscousFriction) {
  std::mt19937 random(7);
  std::vector<TrajectoryRun> slides;
  for (const double ratio : {0.3, 0.5, 0.7, 0.9, 1.1}) {
    slides.push_back(slide_track(motion_of(ratio), ratio, {}, random, false));
    slides.back().name += std::to_string(slides.size());
  }
  const FitResult fit = fit_of(slides);
  EXPECT_EQ(fit.verdict, Use::care);
  EXPECT_TRUE(holds_under(fit, "unseen_spin")) << fit.full_report();
  EXPECT_THAT(fit.improve_first, testing::HasSubstr("turning is seen"));
  EXPECT_LT(fit.parameters.front().ci95.low, 0.17);
  EXPECT_GT(fit.parameters.front().ci95.high, 0.17);
}

TEST(SpinningSlideFit, WhereTheDecelerationIsConstantTheSpinThatWasNotSeenIsSaid) {
  std::mt19937 random(4);
  const FitResult blind = fit_of({slide_track(motion_of(0.0), 0.0, {}, random, false)});
  const SlideResult& slide = blind.slides.front();
  EXPECT_FALSE(holds_under(blind, "unseen_spin"));
  EXPECT_NEAR(slide.mu1.value, 0.17, 4 * slide.mu1.sd);
  EXPECT_GT(slide.change_by_half_spin, 0.02);
  EXPECT_THAT(blind.slides.front().sentence, testing::HasSubstr("Spin was not seen"));
}

TEST(ViscousSlides, AreNamedAndQuotedUnderTheLaw) {
  for (const double between : {0.0, 0.3}) {
    const FitResult fit = fit_of(viscous_slides(0.84, between, 7));
    ASSERT_EQ(fit.quoted_under.size(), 1u) << fit.full_report();
    EXPECT_EQ(fit.explanations.front().name, "viscous");
    EXPECT_NEAR(fit.explanations.front().size, 0.84,
                3 * std::hypot(fit.explanations.front().size_sd, between / 2.8));
    EXPECT_LT(fit.parameters.front().ci95.low, 0.19);
    EXPECT_GT(fit.parameters.front().ci95.high, 0.19);
    EXPECT_EQ(fit.verdict, Use::care);
    EXPECT_GT(fit.as_assumed.at(FitParameter::mu1).estimate, 0.2);
    ASSERT_FALSE(fit.mu_of_speed.empty());
    const FrictionAtSpeed& fastest = fit.mu_of_speed.back();
    EXPECT_NEAR(fastest.speed, 0.7, 0.01);
    EXPECT_NEAR(fastest.mu, 0.19 + fit.explanations.front().size * 0.7 / 9.81, 0.01);
    EXPECT_GT(fastest.sd, 0);
  }
}

TEST(StribeckSlides, AreNamedAndQuotedUnderTheLawAtASpeedOfItsOwn) {
  for (const double fading : {0.08, 0.25}) {
    const FitResult fit = fit_of(stribeck_slides(0.3, fading, 7));
    ASSERT_EQ(fit.quoted_under.size(), 1u) << fit.full_report();
    const Explanation& found = fit.explanations.front();
    EXPECT_EQ(found.name, "stribeck");
    EXPECT_NEAR(found.size, 30, 3 * found.size_sd);
    EXPECT_GT(fit.as_assumed.at(FitParameter::mu1).estimate, fit.parameters.front().estimate);
    EXPECT_LT(fit.parameters.front().ci95.low, 0.19);
    EXPECT_GT(fit.parameters.front().ci95.high, 0.19);
    EXPECT_EQ(fit.verdict, Use::care);
    ASSERT_FALSE(fit.mu_of_speed.empty());
    for (const FrictionAtSpeed& at : fit.mu_of_speed)
      EXPECT_NEAR(at.mu, 0.19 * (1 + 0.3 * std::exp(-std::pow(at.speed / fading, 2))), 4 * at.sd) << at.speed;
  }
}

TEST(ViscousSlides, AConstantFrictionIsNotAccused) {
  const FitResult fit = fit_of(viscous_slides(0, 0, 8));
  EXPECT_TRUE(fit.quoted_under.empty()) << fit.full_report();
  EXPECT_TRUE(fit.mu_of_speed.empty());
}

TEST(SpinningSlideFit, HalfSpinIsWhatHalfSpinDoes) {
  // The figure it prints is the error that a disc of that spin would have made.
  std::mt19937 random(5);
  const FitResult spinning = fit_of({slide_track(motion_of(0.5), 0.5, {}, random, false)});
  const double blind = spinning.slides.front().mu1.value;
  EXPECT_NEAR(0.17 / blind - 1, spinning.slides.front().change_by_half_spin, 0.01);
}

TEST(SpinningSlideFit, APartThatBearsOnItsMiddleTurnsOnAndIsFoundAllTheSame) {
  std::mt19937 random(6);
  SlideLook look;
  look.bearing = 0.5;
  const UnitSlide motion(0.5,
                         0.5 / (0.5 * 0.5));  // the rim as fast as the slide, the bearing face half of it
  const FitResult fit = fit_of({slide_track(motion, 1.0, look, random)});
  const SlideResult& slide = fit.slides.front();
  EXPECT_NEAR(slide.spin_ratio.value, 1, 4 * slide.spin_ratio.sd);
  EXPECT_NEAR(slide.bearing.value, 0.5, 4 * slide.bearing.sd + 0.003);
  EXPECT_LT(slide.bearing.sd, 0.05);
  EXPECT_NEAR(slide.mu1.value, 0.17, 3 * slide.mu1.sd);
}

TEST(SpinningSlideFit, AnglesMayBreakOffAndJumpByTurns) {
  std::mt19937 random(7);
  TrajectoryRun run = slide_track(motion_of(1.0), 1.0, {}, random);
  for (std::size_t i = 0; i < run.track.angle.size(); ++i) {
    run.track.angle[i] = std::remainder(run.track.angle[i], 2 * M_PI);
    if (i % 3 == 1) run.track.angle[i] = std::nan("");
  }
  const FitResult fit = fit_of({run});
  EXPECT_NEAR(fit.slides.front().spin_ratio.value, 1, 4 * fit.slides.front().spin_ratio.sd);
  EXPECT_NEAR(fit.slides.front().mu1.value, 0.17, 3 * fit.slides.front().mu1.sd);
}

}  // namespace
}  // namespace tribotrack::fit
