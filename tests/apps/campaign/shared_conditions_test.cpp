// Campaigns whose tracks are made of numbers: a marker on its circle with noise, a part that drifts.
#include "apps/campaign/shared_conditions.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>
#include <numbers>
#include <random>
#include <set>

#include "apps/campaign/fit_stage.h"
#include "apps/program.h"
#include "apps/recording/recording.h"

namespace tribotrack::apps {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

struct Drive {
  double amplitude_y = 0.28e-3;
};

/// 1 s at 400 frames/s; the marker's noise is 1 um, which tells A to 5e-8 m, 0.018 %.
Track track_of(unsigned seed, const Drive& drive) {
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0, 1e-6);
  Track track;
  for (int k = 0; k < 400; ++k) {
    const double t = k / 400.0, phase = 62.8 * t + 0.4;
    track.table.frame.push_back(k);
    track.table.time.push_back(t);
    track.table.position.emplace_back(3e-3 * t + noise(random), -2e-3 * t + noise(random));
    track.table.covariance.push_back(1e-12 * Eigen::Matrix2d::Identity());
    track.table.marker.emplace_back(
        0.28e-3 * std::cos(phase) + noise(random),
        drive.amplitude_y * std::cos(phase + 0.5 * std::numbers::pi) + noise(random));
    track.table.marker_sigma.push_back(1e-6);
  }
  track.table.platform_frame = true;
  track.table.exposure = 1e-4;
  track.mm_per_px = 0.1;
  track.mm_per_px_sd = 0;
  track.scale_source = "given";
  track.frames = 400;
  return track;
}

class SharedConditionsTest : public ProgramTest {
 protected:
  /// `platform`, `camera`: further lines of these tables. A track for each of `drives`, a run each.
  void campaign(const std::string& platform, const std::vector<Drive>& drives, const std::string& camera = "",
                const std::vector<std::string>& of_runs = {}, const std::string& part = "") {
    std::string text = "[platform]\n" + platform + "\n[part]\n" + part +
                       "\n[camera]\nmm_per_px = 0.100000\n" + camera + "\n";
    for (std::size_t k = 0; k < drives.size(); ++k)
      text += "[[run]]\nname = \"r" + std::to_string(k) +
              "\"\nvideo = \"v.cine\"\nphi_rad = 1\ndtau_rad = 2\ncycles = 8\n" +
              (k < of_runs.size() ? of_runs[k] : "") + "\n";
    put(in_folder("c.toml"), text);
    campaign_ = read_campaign(in_folder("c.toml"));
    runs_.clear();
    for (std::size_t k = 0; k < drives.size(); ++k) {
      apps::Run& run = runs_.emplace_back();
      run.given = campaign_.runs[k];
      run.track = track_of(static_cast<unsigned>(k) + 1, drives[k]);
      measure(campaign_, run);
    }
    shared_ = {};
    shared_ = share_conditions(campaign_, runs_);
  }
  std::string refusal(const std::string& platform, const std::vector<Drive>& drives = {{}, {}}) {
    return complaint_of([&] { campaign(platform, drives); });
  }
  Campaign campaign_;
  std::vector<apps::Run> runs_;
  SharedConditions shared_;
};

TEST_F(SharedConditionsTest, WhatNobodyGaveIsWhatNotKnowingCosts) {
  campaign("amplitude_mm = 0.28\namplitude_mm_sd = 0.001\n[fit]\nexact = [\"friction_law\"]", {{}, {}});
  Json json = {{"parameters", {{"mu1", {{"sd", 0.002}}}}}};
  for (const fit::Condition& c : problem_of(campaign_, runs_, shared_).conditions)
    json["budget"].push_back({{"quantity", fit::to_string(c.quantity)},
                              {"sd_of_source", c.sd},
                              {"from", c.from},
                              {"counted", true},
                              {"contribution", {{"mu1", 0.001}}}});
  add_to(json, shared_);
  std::set<std::string> quantities;
  for (const Json& cost : json["what_not_knowing_costs"]) quantities.insert(cost["quantity"]);
  EXPECT_EQ(quantities, (std::set<std::string>{"mm_per_px", "tilt_x_rad", "tilt_y_rad"}));
  EXPECT_THAT(costs_text(json), HasSubstr("tilt_x_rad, sd 0.002 (tilt_x_rad, default sd): mu1 25 %\n"));
}

TEST_F(SharedConditionsTest, AValueSaidToBeExactIsAndIsListed) {
  campaign(
      "amplitude_mm = 0.2802\nangular_frequency_rad_s = 62.8\nphase_shift_rad = \"pi/2\"\n[fit]\nexact = "
      "true",
      {{}, {}});
  EXPECT_DOUBLE_EQ(runs_[1].scenario.drive.amplitude, 0.2802e-3);
  EXPECT_FALSE(runs_[1].amplitude_from_track);
  Json json;
  add_to(json, shared_);
  EXPECT_EQ(json["taken_as_exact"].dump(),
            "[\"amplitude_mm\",\"amplitude_y_mm\",\"angular_frequency_rad_s\",\"phase_shift_rad\","
            "\"gravity_m_s2\",\"tilt_x_rad\",\"tilt_y_rad\",\"mm_per_px\",\"xi_axis_rad\",\"phi_rad\","
            "\"dtau_rad\",\"friction_law\"]");
  EXPECT_TRUE(json["conditions"][0]["given_sd"].is_null());
  EXPECT_NEAR(json["conditions"][0]["given"].get<double>(), 0.2802, 1e-15);
  EXPECT_THAT(conditions_text(shared_.pooled), HasSubstr("0.2802, campaign, taken as exact"));
  ASSERT_EQ(shared_.warnings.size(), 1u);  // once, A_y with it
  EXPECT_THAT(shared_.warnings[0],
              AllOf(HasSubstr("amplitude_mm: the campaign gives 0.2802, the marker shows"),
                    HasSubstr("in 2 runs"), HasSubstr("the given value is used")));
}

TEST_F(SharedConditionsTest, SlipsAreRefusedByName) {
  EXPECT_THAT(refusal("angular_frequency_rad_s = 9.995"), HasSubstr("9.995 is 62.8 rad/s in Hz"));
  EXPECT_THAT(refusal("amplitude_mm = 0.4"),
              HasSubstr("or mm_per_px = 0.1, by which it was measured, is wrong"));
  EXPECT_THAT(refusal("amplitude_mm = 0.28", {{.amplitude_y = 0.1e-3}}),
              HasSubstr("amplitude_y_mm = 0.28 (amplitude_mm, as it is not given)"));
  EXPECT_EQ(refusal("amplitude_mm = 0.24"), "no complaint");  // 17 %: warned
  EXPECT_EQ(shared_.warnings.size(), 1u);
}

// Whatever key an sd has, the problem that is fitted holds it.
TEST_F(SharedConditionsTest, EachSdReachesTheFit) {
  const std::string platform =
      "amplitude_mm = 0.28\namplitude_y_mm = 0.28\nangular_frequency_rad_s = 62.8\nphase_shift_rad = "
      "1.5708\ngravity_m_s2 = 9.81\ntilt_x_rad = 0\ntilt_y_rad = 0\n";
  const std::string camera = "frame_rate_hz = 400\nxi_axis_rad = 0\nworking_distance_mm = 100\n";
  const std::string part = "height_mm = 1\ndiameter_mm = 6\n";
  const std::string run = "amplitude_mm = 0.28\nangular_frequency_rad_s = 62.8\n";
  const auto fingerprint = [&] {
    const fit::Problem problem = problem_of(campaign_, runs_, shared_);
    std::string text;
    for (const fit::Condition& c : problem.conditions)
      text += fmt::format("{} {}\n", fit::to_string(c.quantity), c.sd);
    for (const auto& r : problem.summary_runs) {
      for (std::size_t i = 0; i < r.own.parameters.size(); ++i)
        text += fmt::format("{} {}\n", model::to_string(r.own.parameters[i]),
                            r.own.covariance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(i)));
      text += fmt::format("{}\n", r.scenario.start_phase);
    }
    return text;
  };
  campaign(platform, {{}, {}}, camera, {"", run}, part);
  std::set<std::string> all = {fingerprint()};
  for (const char* key : {"amplitude_mm_sd = 1e-3", "amplitude_y_mm_sd = 1.1e-3",
                          "angular_frequency_rad_s_sd = 0.01", "phase_shift_rad_sd = 0.012",
                          "gravity_m_s2_sd = 0.013", "tilt_x_rad_sd = 0.014", "tilt_y_rad_sd = 0.015"}) {
    campaign(platform + key, {{}, {}}, camera, {"", ""}, part);
    EXPECT_TRUE(all.insert(fingerprint()).second) << key;
  }
  for (const char* key : {"frame_rate_hz_sd = 0.4", "xi_axis_rad_sd = 0.02", "working_distance_mm_sd = 1"}) {
    campaign(platform, {{}, {}}, camera + key, {"", run}, part);
    EXPECT_TRUE(all.insert(fingerprint()).second) << key;
  }
  campaign(platform, {{}, {}}, camera, {"", run}, part + "height_mm_sd = 0.1");
  EXPECT_TRUE(all.insert(fingerprint()).second) << "height_mm_sd";
  for (const char* key : {"amplitude_mm_sd = 1e-3", "angular_frequency_rad_s_sd = 0.01", "phi_rad_sd = 0.01",
                          "dtau_rad_sd = 0.011", "phase_at_zero_rad = 0.4\nphase_at_zero_rad_sd = 1e-4"}) {
    campaign(platform, {{}, {}}, camera, {"", run + key}, part);
    EXPECT_TRUE(all.insert(fingerprint()).second) << key;
  }
  campaign(platform, {{}, {}}, camera, {"", "mm_per_px = 0.1\nmm_per_px_sd = 0.001"}, part);
  EXPECT_EQ(recording_of(campaign_, campaign_.runs[1]).camera.mm_per_px_sd, 0.001);
  campaign(platform, {{}, {}}, camera + "mm_per_px_sd = 0.002", {}, part + "diameter_mm_sd = 0.01");
  EXPECT_EQ(recording_of(campaign_, campaign_.runs[0]).camera.mm_per_px_sd, 0.002);
  EXPECT_EQ(recording_of(campaign_, campaign_.runs[0]).part.diameter_sd_mm, 0.01);
}

}  // namespace
}  // namespace tribotrack::apps
