#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include "apps/measuring/measure_run.h"
#include "apps/measuring/measure_track.h"
#include "apps/program.h"
#include "apps/text/json.h"
#include "fit/free_slides.h"

namespace tribotrack::apps {

namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

RunMeasurement measured() {
  RunMeasurement m;
  fit::Displacement d;
  d.vector = {-3.02329123e-3, 1.2e-3};
  d.covariance << 4e-14, 0, 0, 9e-14;
  d.cycles = 20;
  d.duration = 2;
  d.alpha = fit::Estimate{};  // from the vector
  m.displacement = d;
  fit::PlatformMotion p;
  p.amplitude = {0.28e-3, 2.9e-8};
  p.amplitude_y = {0.27e-3, 2.9e-8};
  p.angular_frequency = {62.8, 6e-5};
  p.phase_shift = {std::numbers::pi / 2, 8e-5};
  p.clockwise = true;
  p.harmonics = {{2, {4e-7, 1e-8}, {1e-9, 1e-8}}, {3, {1e-9, 1e-8}, {1e-9, 2e-8}}};
  m.platform = p;
  m.phase_source = "marker";
  m.phase_at_start = -std::numbers::pi / 2;
  return m;
}

TEST(MeasureText, EveryQuantityIsRoundedWhereItsStandardDeviationSays) {
  RunMeasurement m = measured();
  fit::GateTiming gate;
  gate.phi = {1.0, 1e-3};
  m.gate = gate;
  m.gate_reference = "camera";
  const std::string text = measurement_text(measurement_json(m, {}));
  for (const char* line :
       {"dx_mm {}-3.02329(20)\n", "alpha_rad {}2.763746(89) (158.35 deg)\n", "v_mm_s {}1.62637(11)\n",
        "cycles {}20\n", "sense {}clockwise\n", "harmonics 1 amplitude_mm {}0.000400(10)\n",
        "phi_rad {}1.0000(10) (57.30 deg)\n", "gate phi_counts_from {}camera\n"}) {
    std::string expected(line);
    const auto blanks = expected.find("{}");
    expected.replace(blanks, 2, 36 - blanks, ' ');
    EXPECT_THAT(text, HasSubstr(expected));
  }
  EXPECT_THAT(text, Not(HasSubstr("harmonics 2")));  // none is seen
}

TEST(UnitSlip, NamesTheUsualOnes) {
  EXPECT_EQ(likely_slip("angular_frequency_rad_s", 9.995, 62.8), "9.995 is 62.8 rad/s in Hz");
  EXPECT_EQ(likely_slip("angular_frequency_rad_s", 394.6, 62.8), "394.6 is 62.8 rad/s times 2 pi");
  EXPECT_EQ(likely_slip("angular_frequency_rad_s", 100, 62.8), "100 ms is the period of 62.83 rad/s");
  EXPECT_EQ(likely_slip("amplitude_mm", 0.198, 0.28), "0.198 is 0.28 mm as its root mean square");
  EXPECT_EQ(likely_slip("amplitude_y_mm", 0.028, 0.28), "0.028 is 0.28 mm in cm");
  EXPECT_EQ(likely_slip("diameter_mm", 0.006, 6.02), "0.006 is 6 mm in metres");
  EXPECT_EQ(likely_slip("phase_shift_rad", 0.25, std::numbers::pi / 2), "0.25 is 1.571 rad in turns");
  EXPECT_EQ(likely_slip("phase_shift_rad", 270, -std::numbers::pi / 2), "270 is 4.712 rad in degrees");
}

TEST(UnitSlip, NamesNoneWhereNoneFits) {
  EXPECT_EQ(likely_slip("amplitude_mm", 0.4, 0.28), "");
  EXPECT_EQ(likely_slip("angular_frequency_rad_s", 50, 62.8), "");
  EXPECT_EQ(likely_slip("angular_frequency_rad_s", 0, 62.8), "");
}

// `measure` on the track of a part that slides freely.

class MeasureSlide : public ProgramTest {
 protected:
  void put_track(double ratio, bool with_angle) const {
    std::mt19937 random(3);
    const fit::TrajectoryRun run = test::slide_track(test::UnitSlide(ratio), ratio, {}, random, with_angle);
    std::string csv = "frame,time_s,status,x_mm,y_mm,sigma_x_mm,sigma_y_mm,theta_rad,sigma_theta_rad\n";
    for (std::size_t i = 0; i < run.track.time.size(); ++i) {
      csv += fmt::format("{},{},ok,{},{},0.03,0.03,", run.track.frame[i], run.track.time[i],
                         1e3 * run.track.position[i].x(), 1e3 * run.track.position[i].y());
      csv += with_angle ? fmt::format("{},0.01\n", run.track.angle[i]) : ",\n";
    }
    put(in_folder("slide.csv"), csv);
    put(in_folder("slide.csv.meta.json"),
        R"({"scale": {"mm_per_px": 0.5, "mm_per_px_sd": 0.0005}, "summary": {"disc_px": [10, 10, 31]}})");
  }
};

TEST_F(MeasureSlide, DecelerationStopAndSpin) {
  put_track(1.0, true);
  const Outcome outcome = run("measure slide.csv --json -o m.json");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const Json m = Json::parse(outcome.out);
  EXPECT_EQ(m["kind"], "free_slide");
  const double sd = m["deceleration_mm_s2_sd"];
  EXPECT_NEAR(m["deceleration_mm_s2"], 0.17 * 9810, 4 * sd);
  EXPECT_GT(sd, 0.9e-3 * 0.17 * 9810) << "the scale's 0.1 % is counted";
  EXPECT_NEAR(m["speed_mm_s"], 600, 3);
  EXPECT_NEAR(m["spin_ratio"], 1, 0.02);
  EXPECT_TRUE(m["stop_seen"].get<bool>());
  EXPECT_NEAR(m["stop_time_s"], 0.7 + test::UnitSlide(1.0).stop_time() * 0.6 / (0.17 * 9.81), 0.003);
  EXPECT_EQ(m["blows"].size(), 0u);
  EXPECT_TRUE(std::filesystem::exists(in_folder("m.json.meta.json")));
}

TEST_F(MeasureSlide, SpinNotSeenIsSaid) {
  put_track(0.0, false);
  const Outcome outcome = run("measure slide.csv --free-slide --gravity-m-s2 9.80");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  for (const char* line : {"deceleration_mm_s2 *166.*\n", "gravity_m_s2 *9.8\n", "spin_seen *false\n",
                           "mu1_change_by_half_spin *0"})
    EXPECT_THAT(outcome.out, testing::ContainsRegex(line));
}

// Which motion a track shows decides what `measure` says of it.

class MeasureMotion : public ProgramTest {
 protected:
  /// mm at so many seconds, sds of 1 um, no mark.
  void put_track(const std::function<Eigen::Vector2d(double)>& path) const {
    std::mt19937 random(5);
    std::normal_distribution<> noise(0, 1e-3);
    std::string csv = "t_s,x_mm,y_mm\n";
    for (int k = 0; k < 600; ++k) {
      const Eigen::Vector2d p = path(2e-3 * k);
      csv += fmt::format("{},{},{}\n", 2e-3 * k, p.x() + noise(random), p.y() + noise(random));
    }
    put(in_folder("t.csv"), csv);
  }
  /// Exit 4, the motion by name and in a sentence, and no friction, whatever was asked.
  void expect_no_slide(const std::string& motion, const std::string& remedy) const {
    for (const std::string& asked : {std::string(), std::string(" --free-slide")}) {
      const Outcome outcome = run("measure t.csv --json" + asked);
      EXPECT_EQ(outcome.exit_code, 4) << motion << asked << outcome.err;
      const Json m = Json::parse(outcome.out);
      EXPECT_EQ(m["motion"], motion);
      EXPECT_THAT(outcome.err, HasSubstr(m["motion_sentence"].get<std::string>()));
      EXPECT_THAT(outcome.err, HasSubstr(remedy));
      EXPECT_FALSE(m.contains("mu1"));
      EXPECT_THAT(run("measure t.csv" + asked).out, Not(HasSubstr("mu1")));
    }
  }
};

Eigen::Vector2d circle(double t) {
  return {0.28 * std::cos(62.8 * t) + 4 * t, 0.28 * std::sin(62.8 * t)};
}

// u' = -(a + c u): friction that rises with speed has no single mu1.
TEST_F(MeasureMotion, ASlideWhoseDecelerationIsNotConstantHasNoMu1) {
  constexpr double kA = 1000, kC = 2, kFirst = 700;  // mm/s^2, 1/s, mm/s
  const double stop = std::log(1 + kC * kFirst / kA) / kC;
  put_track([&](double t) {
    const double s = std::min(t, stop);
    return Eigen::Vector2d((kFirst + kA / kC) * (1 - std::exp(-kC * s)) / kC - kA * s / kC, 0);
  });
  expect_no_slide("slide to rest", "not constant");
}

TEST_F(MeasureMotion, ADrivenPartIsNoSlideAndTellsItsFrequency) {
  put_track(circle);
  expect_no_slide("driven", "frequency as it is set (--omega-rad-s)");
  const Json m = Json::parse(run("measure t.csv --json").out);
  EXPECT_NEAR(m["angular_frequency_rad_s"], 62.8, 4 * m["angular_frequency_rad_s_sd"].get<double>());
  const Outcome known = run("measure t.csv --omega-rad-s 62.8 --json");
  EXPECT_EQ(known.exit_code, 0) << known.err;
  EXPECT_NEAR(Json::parse(known.out)["v_mm_s"], 4, 0.01);
  const Outcome in_hz = run("measure t.csv --omega-rad-s 9.995");
  EXPECT_EQ(in_hz.exit_code, 4);
  EXPECT_THAT(in_hz.err, HasSubstr("62.8 rad/s in Hz"));
}

TEST_F(MeasureMotion, WhatSwingsIsPulledRestsOrGainsSpeedIsNoSlide) {
  put_track([](double t) { return Eigen::Vector2d(20 * std::cos(30 * t) * std::exp(-t), 0); });
  expect_no_slide("swinging", "no friction follows");
  put_track([](double t) { return Eigen::Vector2d(100 * t, 20 * t); });
  expect_no_slide("pulled", "let go");
  put_track([](double) { return Eigen::Vector2d(3, 4); });
  expect_no_slide("at rest", "while it moves");
  put_track([](double t) { return Eigen::Vector2d(500 * t * t, 0); });
  expect_no_slide("incline", "slope_rad");
}

TEST_F(MeasureMotion, ASlideIsNamedAndADriveThatIsNoneIsNot) {
  put_track([](double t) {
    const double s = std::min(t, 0.4);
    return Eigen::Vector2d(600 * s - 750 * s * s, 0);
  });
  const Outcome slide = run("measure t.csv --json");
  ASSERT_EQ(slide.exit_code, 0) << slide.err;
  EXPECT_EQ(Json::parse(slide.out)["motion"], "slide to rest");
  EXPECT_NEAR(Json::parse(slide.out)["deceleration_mm_s2"], 1500, 1);
  const Outcome driven = run("measure t.csv --omega-rad-s 62.8");
  EXPECT_EQ(driven.exit_code, 4);
  EXPECT_THAT(driven.err, HasSubstr("no drive"));
}

/// A camera held by hand: its mark circles nowhere.
TEST(TrackMotion, AMarkThatDoesNotCircleMovedWithTheCamera) {
  Track track;
  std::mt19937 random(3);
  std::normal_distribution<> noise(0, 1e-6), hand(0, 2e-4);
  Eigen::Vector2d camera(0, 0);
  for (int k = 0; k < 300; ++k) {
    camera += Eigen::Vector2d(hand(random), hand(random));
    track.table.frame.push_back(k);
    track.table.time.push_back(2e-3 * k);
    track.table.position.emplace_back(noise(random), noise(random));
    track.table.covariance.push_back(1e-12 * Eigen::Matrix2d::Identity());
    track.table.marker.emplace_back(camera);
    track.table.marker_sigma.push_back(1e-6);
  }
  track.table.platform_frame = true;
  const TrackMotion motion = motion_of(track, fit::measure_platform_motion(track.table));
  EXPECT_EQ(motion.shown.kind, fit::MotionKind::with_background);
  EXPECT_THAT(motion.sentence, HasSubstr("the part goes with it"));
}

// What a coder does to the platform's motion, as measured.

constexpr double kW = 62.8, kA = 0.28e-3, kPhase = 1.1, kNoise = 1e-6;

Track circling(std::optional<vision::CodedErrors> coding) {
  Track track;
  track.mm_per_px = 0.1;
  track.mm_per_px_sd = 0;
  track.coding = std::move(coding);
  track.table.platform_frame = true;
  track.table.exposure = 1e-5;
  std::mt19937 random(3);
  std::normal_distribution<> noise(0, kNoise);
  for (int k = 0; k < 400; ++k) {
    const double t = 2e-3 * k, phase = kW * t + kPhase;
    track.table.frame.push_back(k);
    track.table.time.push_back(t);
    track.table.position.emplace_back(1e-3 * t, 0);
    track.table.covariance.push_back(kNoise * kNoise * Eigen::Matrix2d::Identity());
    track.table.marker.emplace_back(kA * std::cos(phase) + noise(random),
                                    -kA * std::sin(phase) + noise(random));
    track.table.marker_sigma.push_back(kNoise);
  }
  return track;
}

TEST(Mark, IsToBeSeenInMostFramesAndToStay) {
  Track track = circling({});
  EXPECT_TRUE(measure_run("a", track, {}).warnings.empty());
  track.without_mark = 10;
  EXPECT_THAT(measure_run("a", track, {}).warnings, ElementsAre(HasSubstr("10 frames are left out")));
  track.without_mark = 401;
  EXPECT_THROW(measure_run("a", track, {}), fit::DataError);
  track.without_mark = 0;
  for (std::size_t k = 0; k < 400; ++k)
    track.table.marker[k].x() += 4e-3 * track.table.time[k];  // another part
  EXPECT_THAT(measure_run("a", track, {}).warnings, ElementsAre(HasSubstr("drifts by 3.2 mm")));
}

/// Nobody knows how much of it there was: the values stay, and all of it stands in their standard deviations.
TEST(CodedMotion, UnknownCoderIsCountedInFull) {
  vision::CodedErrors errors;
  errors.coder = "h264";
  errors.mark_play = 0.05;
  const RunMeasurement plain = measure_run("plain", circling({}), {}),
                       coded = measure_run("coded", circling(errors), {});
  EXPECT_FALSE(plain.coded);
  ASSERT_TRUE(coded.coded);
  const double amplitude = std::max(plain.platform->amplitude.value, plain.platform->amplitude_y.value);
  const fit::SeenThroughPlay play = fit::seen_through_play(amplitude, 0.05 * 0.1e-3);
  EXPECT_DOUBLE_EQ(coded.coded->delay, play.delay);
  EXPECT_DOUBLE_EQ(coded.platform->phase_at_zero.value, plain.platform->phase_at_zero.value);
  EXPECT_NEAR(coded.platform->phase_at_zero.sd, std::hypot(plain.platform->phase_at_zero.sd, play.delay),
              1e-12);
  const double attenuation = std::max(play.attenuation, 0.5 * 0.05 * 0.1e-3 / amplitude);
  EXPECT_NEAR(coded.platform->amplitude.sd,
              std::hypot(plain.platform->amplitude.sd, attenuation * plain.platform->amplitude.value), 1e-15);
  EXPECT_EQ(coded.coded->exceeds,
            play.delay > 1.96 * plain.platform->phase_at_middle.sd ||
                attenuation * plain.platform->amplitude.value > 1.96 * plain.platform->amplitude.sd);
  EXPECT_TRUE(coded.coded->exceeds) << "0.02 rad against a phase known to 0.001";
  EXPECT_THAT(coded.warnings, testing::Contains(testing::HasSubstr("codec (h264)")));
}

}  // namespace

}  // namespace tribotrack::apps
