// Laws of fit::pool over campaigns made of numbers: what marks show of a platform, and what is given of it.
#include "fit/conditions.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "fit/pooling.h"

namespace tribotrack::fit {
namespace {

using model::Parameter;
using ::testing::Contains;
using ::testing::Not;
using From = PooledQuantity::From;

constexpr double pi = std::numbers::pi;

/// A mark that shows A to 1e-4 of it, A_y to 2e-4, w to 1e-5 and epsilon to 1e-3 rad.
RunEvidence shown(double amplitude = 0.28e-3) {
  RunEvidence run;
  run.seen.emplace();
  run.seen->amplitude = {amplitude, 1e-4 * amplitude};
  run.seen->amplitude_y = {amplitude, 2e-4 * amplitude};
  run.seen->angular_frequency = {62.8, 62.8e-5};
  run.seen->phase_shift = {pi / 2, 1e-3};
  run.seen->middle_time = 0.5;
  run.scale = {0.1, 0, Source::scale};
  run.start_assumed = false;
  return run;
}

GivenValue all(double value, double sd = 0) {
  return {{value, sd}, false};
}
GivenValue of_run(double value, double sd = 0) {
  return {{value, sd}, true};
}

Conditions pooled(const std::vector<RunEvidence>& runs, const SharedEvidence& shared = {}) {
  std::vector<RunConditions> start;
  for (const RunEvidence& run : runs) start.push_back({{}, settle_timing(run).own});
  return pool(runs, shared, start);
}

/// Root of the sum of squares over its sources.
double error_of(const Conditions& c, FitParameter quantity, const std::string& from = "") {
  double variance = 0;
  for (const SharedError& e : c.errors)
    if (e.quantity == quantity && (from.empty() || e.from == from)) variance += e.sd * e.sd;
  return std::sqrt(variance);
}

TEST(Conditions, WhatAllShowIsOneQuantityWithOneError) {
  std::vector<RunEvidence> runs(4, shown());
  runs[1].seen->amplitude = {0.28006e-3, 4e-8};
  const Conditions c = pooled(runs);
  const double w = 1 / (2.8e-8 * 2.8e-8), w1 = 1 / (4e-8 * 4e-8), all = 3 * w + w1;
  const double mean = (3 * w * 0.28e-3 + w1 * 0.28006e-3) / all;
  const PooledQuantity& a = *c.find(Source::amplitude);
  EXPECT_NEAR(a.used.value, mean, 1e-15);
  EXPECT_NEAR(a.used.sd, 1 / std::sqrt(all), 1e-15);
  EXPECT_EQ(a.from, From::measured);
  EXPECT_EQ(c.from(a), "marker, 4 runs");
  EXPECT_FALSE(a.given);
  for (const RunConditions& run : c.runs) {
    EXPECT_EQ(run.drive.amplitude, c.runs[0].drive.amplitude);
    EXPECT_NEAR(run.drive.amplitude, mean, 1e-15);
    EXPECT_TRUE(run.amplitude_from_track);
    EXPECT_EQ(run.own.sd(Parameter::amplitude), 0);
  }
  // Independent relative errors u and 2v of A and A_y: of their mean half, of their ratio the whole of the
  // root.
  const double u = 1 / std::sqrt(all) / mean, v = 2e-4 / 2;
  EXPECT_NEAR(error_of(c, FitParameter::amplitude), std::hypot(u, v) / 2, 1e-12);
  EXPECT_NEAR(error_of(c, FitParameter::amplitude_ratio), std::hypot(u, v), 1e-12);
  EXPECT_NEAR(error_of(c, FitParameter::angular_frequency), 1e-5 / 2, 1e-12);
  EXPECT_NEAR(error_of(c, FitParameter::phase_shift), 1e-3 / 2, 1e-12);
  EXPECT_THAT(c.taken_as_exact, Not(Contains(Source::amplitude)));
}

// Whatever is given, and whatever all recordings share: used less true, over its sd, scatters by 1.
TEST(Conditions, StandardDeviationsAreTheScatterOverCampaigns) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  for (const double given_sd : {0.0, 2e-4, 1e-3}) {
    double squares = 0;
    constexpr int kCampaigns = 2000;
    for (int k = 0; k < kCampaigns; ++k) {
      const double common = 3e-4 * normal(random), given = 0.28e-3 * (1 + given_sd * normal(random));
      std::vector<RunEvidence> runs;
      for (const double own : {1e-4, 4e-4, 8e-4}) {
        runs.push_back(shown());
        runs.back().scale->relative_sd = 3e-4;
        runs.back().seen->amplitude = {0.28e-3 * (1 + common + own * normal(random)), 0.28e-3 * own};
        if (given_sd > 0) runs.back().amplitude = all(given, 0.28e-3 * given_sd);
      }
      const Estimate used = pooled(runs).find(Source::amplitude)->used;
      squares += std::pow((used.value - 0.28e-3) / used.sd, 2);
    }
    EXPECT_NEAR(squares / kCampaigns, 1, 4 * std::sqrt(2.0 / kCampaigns)) << given_sd;
  }
}

TEST(Conditions, WhatRecordingsShareIsNotAveragedOut) {
  std::vector<RunEvidence> runs(16, shown());
  for (RunEvidence& run : runs) {
    run.seen->exposure_doubt = 0.01;
    run.coder_attenuation = 0.02;
    run.seen->amplitude.sd = std::hypot(1e-4, 0.01, 0.02) * run.seen->amplitude.value;
    run.seen->amplitude_y.sd = std::hypot(2e-4, 0.01, 0.02) * run.seen->amplitude_y.value;
    run.coder_delay = 0.03;
  }
  const Conditions c = pooled(runs);
  EXPECT_NEAR(c.find(Source::amplitude)->used.sd / 0.28e-3, std::hypot(1e-4 / 4, 0.01, 0.02), 1e-9);
  EXPECT_NEAR(error_of(c, FitParameter::amplitude, kFromCoder), 0.02, 1e-12);
  EXPECT_NEAR(error_of(c, FitParameter::amplitude, "exposure, not known"), 0.01, 1e-12);
  EXPECT_NEAR(error_of(c, FitParameter::phase_reference), 0.03, 1e-12);
  EXPECT_NEAR(error_of(c, FitParameter::amplitude_ratio), std::hypot(1e-4, 2e-4) / 4, 1e-9);
  for (RunEvidence& run : runs) run.amplitude = all(0.28e-3);  // not from the track
  EXPECT_EQ(error_of(pooled(runs), FitParameter::amplitude), 0);
}

TEST(Conditions, RunsThatDifferKeepTheirOwn) {
  std::vector<RunEvidence> runs(3, shown());
  runs[2].seen->amplitude.value = 0.283e-3;
  runs[1].seen->angular_frequency.value = 62.9;
  const Conditions c = pooled(runs);
  const PooledQuantity &a = *c.find(Source::amplitude), &w = *c.find(Source::angular_frequency);
  EXPECT_EQ(a.from, From::each_its_own);
  EXPECT_LT(a.p_value, kRefusedByChance);
  ASSERT_TRUE(a.scatter && w.scatter);
  EXPECT_EQ(a.scatter->low, 0.28e-3);
  EXPECT_EQ(a.scatter->high, 0.283e-3);
  EXPECT_EQ(a.scatter->runs, 3u);
  EXPECT_FALSE(c.find(Source::amplitude_y)->scatter);
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_EQ(c.runs[k].drive.amplitude, runs[k].seen->amplitude.value);
    EXPECT_NEAR(c.runs[k].own.sd(Parameter::amplitude), runs[k].seen->amplitude.sd, 1e-18);
    EXPECT_EQ(c.runs[k].drive.amplitude_y, c.runs[0].drive.amplitude_y);
    // The phase at the start, half a second before the middle, went with w.
    const auto& own = c.runs[k].own;
    const auto at = [&](Parameter p) {
      return std::ranges::find(own.parameters, p) - own.parameters.begin();
    };
    EXPECT_NEAR(own.covariance(at(Parameter::angular_frequency), at(Parameter::start_phase)),
                -0.5 * std::pow(62.8e-5, 2), 1e-15);
  }
  EXPECT_EQ(error_of(c, FitParameter::angular_frequency), 0);
}

TEST(Conditions, AGivenValueWithoutAnSdIsExactAndSaidSo) {
  std::vector<RunEvidence> runs(2, shown());
  for (RunEvidence& run : runs) {
    run.amplitude = all(0.2802e-3);
    run.angular_frequency = all(62.8);
    run.phase_shift = all(pi / 2);
  }
  const Conditions c = pooled(runs);
  EXPECT_TRUE(c.errors.empty());
  EXPECT_EQ(c.runs[1].drive.amplitude, 0.2802e-3);
  EXPECT_EQ(c.runs[1].drive.amplitude_y, 0.2802e-3);
  EXPECT_FALSE(c.runs[1].amplitude_from_track);
  EXPECT_THAT(c.taken_as_exact,
              testing::ElementsAre(Source::amplitude, Source::amplitude_y, Source::angular_frequency,
                                   Source::phase_shift, Source::gravity, Source::tilt_x, Source::tilt_y,
                                   Source::scale, Source::sensor_axis, Source::phi, Source::dtau,
                                   Source::friction_law));
  const PooledQuantity& a = *c.find(Source::amplitude);
  EXPECT_NEAR(*a.difference_in_sd, -0.2e-6 / (2.8e-8 / std::sqrt(2.0)), 0.02);
  EXPECT_TRUE(a.contradicted());
  EXPECT_TRUE(c.find(Source::amplitude_y)->implied);
  EXPECT_FALSE(c.find(Source::phase_shift)->contradicted());
}

TEST(Conditions, WhatNobodyKnowsHasAnErrorThatIsNoPrior) {
  RunEvidence run;  // measured elsewhere
  run.amplitude = all(0.28e-3, 2.8e-6);
  SharedEvidence shared;
  shared.assumed = {Source::amplitude, Source::tilt_x};
  shared.tilt_x_sd = shared.tilt_y_sd = 2e-3;
  shared.amplitude_ratio_sd = 0.01;
  shared.phase_shift_sd = 0.02;
  shared.start_phase_sd = kUnknownAngle;
  const Conditions c = pooled({run, run}, shared);
  EXPECT_NEAR(error_of(c, FitParameter::amplitude, "campaign, default sd"), 0.01, 1e-12);
  EXPECT_NEAR(error_of(c, FitParameter::amplitude_ratio), 0.01, 1e-15);
  EXPECT_NEAR(error_of(c, FitParameter::phase_shift), 0.02, 1e-15);
  EXPECT_NEAR(error_of(c, FitParameter::start_phase), pi / std::sqrt(3.0), 1e-12);
  for (const SharedError& e : c.errors) {
    EXPECT_EQ(is_assumed(e.from), e.quantity != FitParameter::tilt_y) << e.from;
    EXPECT_EQ(e.known_beforehand, e.quantity == FitParameter::tilt_y) << e.from;
  }
  EXPECT_THAT(c.taken_as_exact, testing::ElementsAre(Source::gravity, Source::sensor_axis, Source::phi,
                                                     Source::dtau, Source::friction_law));
  // Of one amplitude that is seen the ratio is, too.
  std::vector<RunEvidence> runs(2, shown());
  for (RunEvidence& seen : runs) seen.amplitude = all(0.28e-3);
  const Conditions exact_x = pooled(runs, shared);
  EXPECT_EQ(exact_x.find(Source::amplitude)->from, From::given_exactly);
  EXPECT_EQ(exact_x.find(Source::amplitude_y)->from, From::given_and_measured);
  EXPECT_NEAR(exact_x.find(Source::amplitude_y)->used.sd, 2e-4 / std::sqrt(2.0) * 0.28e-3, 1e-11);
}

TEST(Conditions, AStartThatOthersTellIsItsOwnUnknown) {
  RunEvidence told, untold, circling;
  told.start_phase = Estimate{1, 0};
  circling.from_rest = false;
  SharedEvidence shared;
  shared.start_phase_sd = kUnknownAngle;
  const Conditions mixed = pooled({told, untold, circling}, shared);
  EXPECT_EQ(error_of(mixed, FitParameter::start_phase), 0);
  EXPECT_EQ(mixed.runs[0].own.sd(Parameter::start_phase), 0);
  EXPECT_NEAR(mixed.runs[1].own.sd(Parameter::start_phase), kUnknownAngle, 1e-12);
  EXPECT_EQ(mixed.runs[2].own.sd(Parameter::start_phase), 0);
  EXPECT_EQ(error_of(pooled({told, circling}, shared), FitParameter::start_phase), 0);
  shared.start_phase_sd = 0;
  EXPECT_THAT(pooled({untold}, shared).taken_as_exact, Contains(Source::start_phase));
}

TEST(Conditions, RunsCommandedDifferentlyArePooledByTheirRatio) {
  std::vector<RunEvidence> runs = {shown(0.202e-3), shown(0.303e-3), shown(0.404e-3)};
  for (std::size_t k = 0; k < 3; ++k) {
    runs[k].amplitude = of_run(1e-4 * static_cast<double>(k + 2), 1e-6 * static_cast<double>(k + 2));
  }
  const Conditions c = pooled(runs);
  const PooledQuantity& a = *c.find(Source::amplitude);
  EXPECT_NEAR(a.measured->value / a.given->value, 1.01, 1e-12);  // all a percent more than commanded
  EXPECT_NEAR(a.p_value, 1, 1e-9);
  EXPECT_EQ(a.runs, 3u);
  // What is given for a run errs for that run alone, A_y with A.
  EXPECT_EQ(a.shared_sd, 0);
  for (const RunConditions& run : c.runs) {
    EXPECT_NEAR(run.own.sd(Parameter::amplitude) / run.drive.amplitude, 1e-2 / std::sqrt(3.0), 3e-3);
    EXPECT_GT(run.own.sd(Parameter::amplitude), 0);
  }
}

TEST(Conditions, OneErrorMovesAnAmplitudeThatIsGivenForBothAxes) {
  RunEvidence run;  // measured elsewhere
  run.amplitude = of_run(0.28e-3, 2e-6);
  const Conditions own = pooled({run});
  ASSERT_EQ(own.runs[0].own.parameters, (std::vector{Parameter::amplitude, Parameter::amplitude_y}));
  EXPECT_TRUE(own.runs[0].own.covariance.isApprox(Eigen::Matrix2d::Constant(4e-12)));
  run.amplitude = all(0.28e-3, 2.8e-6);
  const Conditions shared = pooled({run});
  EXPECT_NEAR(error_of(shared, FitParameter::amplitude), 0.01, 1e-15);
  EXPECT_EQ(error_of(shared, FitParameter::amplitude_ratio), 0);
  EXPECT_THAT(shared.taken_as_exact, Contains(Source::amplitude_y));
}

TEST(Conditions, AClockThatIsOffIsAGravityThatIsOffTwiceOrAScale) {
  std::vector<RunEvidence> runs(2, shown());
  SharedEvidence shared;
  shared.clock_sd = 1e-3;
  const Conditions measured = pooled(runs, shared);
  EXPECT_NEAR(error_of(measured, FitParameter::gravity), 2e-3, 1e-15);
  EXPECT_NEAR(measured.find(Source::angular_frequency)->measured->sd, 62.8e-3, 1e-5);
  for (RunEvidence& run : runs) run.angular_frequency = all(62.8);
  const Conditions given = pooled(runs, shared);
  EXPECT_EQ(error_of(given, FitParameter::gravity), 0);
  EXPECT_NEAR(error_of(given, FitParameter::scale), 1e-3, 1e-15);
}

TEST(Conditions, TheScalesErrorsStandApart) {
  std::vector<RunEvidence> runs(2, shown());
  SharedEvidence shared;
  shared.length_sd = 3e-3;
  shared.parallax_sd = 1e-3;
  for (RunEvidence& run : runs) run.scale = {0.1, 5e-3, Source::diameter};
  const Conditions one = pooled(runs, shared);
  EXPECT_NEAR(error_of(one, FitParameter::scale, "diameter_mm_sd, campaign"), 3e-3, 1e-15);
  EXPECT_NEAR(error_of(one, FitParameter::scale, "part's radius in the pictures"), 4e-3, 1e-15);
  EXPECT_NEAR(error_of(one, FitParameter::scale), 5e-3, 1e-15);  // the part's top is measured by itself
  EXPECT_NEAR(error_of(one, FitParameter::amplitude, "height and working distance, campaign"), 1e-3, 1e-15);
  EXPECT_NEAR(one.find(Source::amplitude)->used.sd / 0.28e-3, std::hypot(5e-3, 1e-3), 1e-5);
  // Where each has its own scale only the true length is common, and the rest averages out.
  runs[1].scale->mm_per_px = 0.11;
  EXPECT_NEAR(pooled(runs, shared).find(Source::amplitude)->used.sd / 0.28e-3,
              std::hypot(3e-3, 1e-3, 4e-3 / std::sqrt(2.0)), 1e-5);
  for (RunEvidence& run : runs) run.scale->by = Source::tag;
  shared.scale = Source::tag;
  const Conditions tag = pooled(runs, shared);
  EXPECT_NEAR(error_of(tag, FitParameter::scale, "the tag's size, and its sides in the pictures"), 5e-3,
              1e-15);
  EXPECT_NEAR(error_of(tag, FitParameter::scale, "height and working distance, campaign"), 1e-3, 1e-15);
}

TEST(Conditions, ATurnedCameraErrsWherePhiCountsFromTheSensor) {
  std::vector<RunEvidence> runs(2, shown());
  SharedEvidence shared;
  shared.sensor_axis_sd = 0.01;
  EXPECT_NEAR(error_of(pooled(runs, shared), FitParameter::phase_reference), 0.01, 1e-15);
  runs[0].gate.emplace();
  runs[0].gate_by_camera = true;
  const Conditions mixed = pooled(runs, shared);
  EXPECT_EQ(error_of(mixed, FitParameter::phase_reference), 0);
  EXPECT_EQ(mixed.runs[0].own.sd(Parameter::phi), 0);
  EXPECT_NEAR(mixed.runs[1].own.sd(Parameter::phi), 0.01, 1e-15);
  runs[1] = runs[0];
  const Conditions camera = pooled(runs, shared);
  EXPECT_TRUE(camera.sensor_axis_not_used);
  EXPECT_THAT(camera.taken_as_exact, Not(Contains(Source::sensor_axis)));
}

TEST(Conditions, SlipsAreThoseOfARunOrOfAll) {
  std::vector<RunEvidence> runs(3, shown());
  EXPECT_TRUE(pooled(runs).slips.empty());
  runs[1].amplitude = of_run(0.56e-3);
  runs[2].amplitude = of_run(0.28e-3);
  std::vector<Slip> slips = pooled(runs).slips;
  ASSERT_EQ(slips.size(), 2u);  // A_y with it
  EXPECT_EQ(slips[0].run, 1u);
  EXPECT_EQ(slips[0].runs, 1u);
  EXPECT_FALSE(slips[0].everywhere);
  for (RunEvidence& run : runs) run.amplitude = all(0.24e-3);  // 17 %: a contradiction
  EXPECT_TRUE(pooled(runs).slips.empty());
  EXPECT_TRUE(pooled(runs).find(Source::amplitude)->contradicted());
  for (RunEvidence& run : runs) {
    run.amplitude = all(0);  // said to rest
    run.phase_shift = all(pi / 2 + 0.4);
  }
  slips = pooled(runs).slips;
  ASSERT_EQ(slips.size(), 3u);
  EXPECT_TRUE(slips[0].everywhere);
  EXPECT_EQ(slips[0].runs, 3u);
  EXPECT_EQ(slips[2].quantity, Source::phase_shift);
}

TEST(Conditions, ADiameterChecksAGivenScale) {
  std::vector<RunEvidence> runs(2, shown());
  SharedEvidence shared;
  shared.diameter = Estimate{6.1e-3, 0};
  for (RunEvidence& run : runs) run.diameter = Estimate{6e-3, 6e-6};
  const Conditions c = pooled(runs, shared);
  EXPECT_TRUE(c.slips.empty());
  EXPECT_NEAR(c.find(Source::diameter)->measured->value, 6e-3, 1e-15);
  EXPECT_NEAR(c.find(Source::diameter)->measured->sd, 6e-6, 1e-12);  // all recordings share it
  shared.diameter = Estimate{3e-3, 0};
  EXPECT_EQ(pooled(runs, shared).slips.size(), 1u);
  for (RunEvidence& run : runs) run.scale->by = Source::diameter;
  EXPECT_EQ(pooled(runs, shared).find(Source::diameter), nullptr);
}

/// Four runs that differ in everything.
std::vector<RunEvidence> mixed_runs() {
  std::vector<RunEvidence> runs = {shown(0.2803e-3), shown(), shown(0.35e-3), shown(0.2801e-3)};
  for (RunEvidence& run : runs) run.angular_frequency = all(62.801, 1e-3);
  runs[0].amplitude = runs[1].amplitude = all(0.2802e-3, 1e-8);
  runs[2].amplitude = of_run(0.3501e-3, 3e-8);
  runs[3].seen->phase_shift.value = 1.572;
  runs[3].scale->relative_sd = 1e-3;
  return runs;
}

TEST(Conditions, TheOrderOfRunsChangesNothing) {
  const std::vector<RunEvidence> runs = mixed_runs();
  const Conditions before = pooled(runs);
  const std::vector<RunEvidence> turned = {runs[1], runs[0], runs[3], runs[2]};
  const Conditions after = pooled(turned);
  constexpr std::size_t kThere[] = {1, 0, 3, 2};
  for (std::size_t k = 0; k < 4; ++k) {
    const RunConditions &one = before.runs[k], &other = after.runs[kThere[k]];
    EXPECT_DOUBLE_EQ(one.drive.amplitude, other.drive.amplitude);
    EXPECT_NEAR(one.drive.phase_shift, other.drive.phase_shift, 1e-15);
    EXPECT_NEAR(one.own.sd(Parameter::amplitude) / other.own.sd(Parameter::amplitude), 1, 1e-9);
  }
  ASSERT_EQ(before.errors.size(), after.errors.size());
  for (std::size_t k = 0; k < before.errors.size(); ++k)
    EXPECT_NEAR(before.errors[k].sd / after.errors[k].sd, 1, 1e-9) << before.errors[k].from;
}

TEST(Conditions, UnitsOfLengthAndTimeChangeNothing) {
  const Conditions before = pooled(mixed_runs());
  std::vector<RunEvidence> runs = mixed_runs();
  const auto times = [](Estimate& e, double unit) { e = {e.value * unit, e.sd * unit}; };
  for (RunEvidence& run : runs) {
    times(run.seen->amplitude, 1e3);
    times(run.seen->amplitude_y, 1e3);
    times(run.seen->angular_frequency, 60);
    times(run.angular_frequency->value, 60);
    if (run.amplitude) times(run.amplitude->value, 1e3);
  }
  const Conditions after = pooled(runs);
  for (std::size_t k = 0; k < before.quantities.size(); ++k) {
    const PooledQuantity &one = before.quantities[k], &other = after.quantities[k];
    EXPECT_NEAR(one.used.sd / one.used.value / (other.used.sd / other.used.value), 1, 1e-9);
    EXPECT_NEAR(one.p_value, other.p_value, 1e-6);
    EXPECT_EQ(one.from, other.from);
    EXPECT_NEAR(one.difference_in_sd.value_or(0), other.difference_in_sd.value_or(0), 1e-6);
  }
  ASSERT_EQ(before.errors.size(), after.errors.size());
  for (std::size_t k = 0; k < before.errors.size(); ++k)
    EXPECT_NEAR(before.errors[k].sd / after.errors[k].sd, 1, 1e-9) << before.errors[k].from;
}

TEST(Conditions, AnSdIsAConditionOrThePriorOfWhatIsFitted) {
  RunEvidence run;
  run.amplitude = all(0.28e-3, 2e-6);
  run.angular_frequency = all(62.8);
  SharedEvidence shared;
  shared.tilt_x_sd = 5e-4;
  shared.gravity_sd = 1e-3;
  const Conditions c = pooled({run}, shared);
  Problem problem;
  problem.free = {FitParameter::mu1, FitParameter::amplitude, FitParameter::tilt_x};
  problem.summary_runs.emplace_back();
  problem.summary_runs[0].scenario.drive = c.runs[0].drive;
  problem.summary_runs[0].scenario.drive.tilt_x = 1e-3;
  put_into(problem, c);
  ASSERT_EQ(problem.conditions.size(), 1u);
  EXPECT_EQ(problem.conditions[0].quantity, FitParameter::gravity);
  EXPECT_NEAR(problem.conditions[0].sd, 9.81e-3, 1e-12);
  EXPECT_EQ(problem.conditions[0].from, "gravity_m_s2_sd, campaign");
  EXPECT_NEAR(problem.prior.at(FitParameter::amplitude).mean, 0.28e-3, 1e-15);
  EXPECT_NEAR(problem.prior.at(FitParameter::amplitude).sd, 2e-6, 1e-15);
  EXPECT_NEAR(problem.prior.at(FitParameter::tilt_x).mean, 1e-3, 1e-15);
  EXPECT_NEAR(problem.prior.at(FitParameter::tilt_x).sd, 5e-4, 1e-15);
  // What the same marks measured is no prior: the fit finds it again.
  Problem measured;
  measured.free = {FitParameter::amplitude};
  measured.summary_runs = problem.summary_runs;
  put_into(measured, pooled({shown(), shown()}));
  EXPECT_TRUE(measured.prior.empty());
}

}  // namespace
}  // namespace tribotrack::fit
