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

using ::testing::HasSubstr;

/// 1 s at 400 frames/s; the marker's noise is 1 um, which tells A to 5e-8 m, 0.018 %.
Track track_of(unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0, 1e-6);
  Track track;
  for (int k = 0; k < 400; ++k) {
    const double t = k / 400.0, phase = 62.8 * t + 0.4;
    track.table.frame.push_back(k);
    track.table.time.push_back(t);
    track.table.position.emplace_back(3e-3 * t + noise(random), -2e-3 * t + noise(random));
    track.table.covariance.push_back(1e-12 * Eigen::Matrix2d::Identity());
    track.table.marker.emplace_back(0.28e-3 * std::cos(phase) + noise(random),
                                    0.28e-3 * std::cos(phase + 0.5 * std::numbers::pi) + noise(random));
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
  /// `platform`, `camera`: further lines of these tables. Two runs with a track each.
  void campaign(const std::string& platform, const std::string& camera = "",
                const std::vector<std::string>& of_runs = {}, const std::string& part = "") {
    std::string text = "[platform]\n" + platform + "\n[part]\n" + part +
                       "\n[camera]\nmm_per_px = 0.100000\n" + camera + "\n";
    for (std::size_t k = 0; k < 2; ++k)
      text += "[[run]]\nname = \"r" + std::to_string(k) +
              "\"\nvideo = \"v.cine\"\nphi_rad = 1\ndtau_rad = 2\ncycles = 8\n" +
              (k < of_runs.size() ? of_runs[k] : "") + "\n";
    put(in_folder("c.toml"), text);
    campaign_ = read_campaign(in_folder("c.toml"));
    runs_.clear();
    for (std::size_t k = 0; k < 2; ++k) {
      apps::Run& run = runs_.emplace_back();
      run.given = campaign_.runs[k];
      run.track = track_of(static_cast<unsigned>(k) + 1);
      measure(campaign_, run);
    }
    shared_ = {};
    shared_ = share_conditions(campaign_, runs_);
  }

  Campaign campaign_;
  std::vector<apps::Run> runs_;
  SharedConditions shared_;
};

TEST_F(SharedConditionsTest, WhatNobodyGaveIsWhatNotKnowingCosts) {
  campaign("amplitude_mm = 0.28\namplitude_mm_sd = 0.001\n[fit]\nexact = [\"friction_law\"]");
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
  campaign(platform, camera, {"", run}, part);
  std::set<std::string> all = {fingerprint()};
  for (const char* key : {"amplitude_mm_sd = 1e-3", "amplitude_y_mm_sd = 1.1e-3",
                          "angular_frequency_rad_s_sd = 0.01", "phase_shift_rad_sd = 0.012",
                          "gravity_m_s2_sd = 0.013", "tilt_x_rad_sd = 0.014", "tilt_y_rad_sd = 0.015"}) {
    campaign(platform + key, camera, {"", ""}, part);
    EXPECT_TRUE(all.insert(fingerprint()).second) << key;
  }
  for (const char* key : {"frame_rate_hz_sd = 0.4", "xi_axis_rad_sd = 0.02", "working_distance_mm_sd = 1"}) {
    campaign(platform, camera + key, {"", run}, part);
    EXPECT_TRUE(all.insert(fingerprint()).second) << key;
  }
  campaign(platform, camera, {"", run}, part + "height_mm_sd = 0.1");
  EXPECT_TRUE(all.insert(fingerprint()).second) << "height_mm_sd";
  for (const char* key : {"amplitude_mm_sd = 1e-3", "angular_frequency_rad_s_sd = 0.01", "phi_rad_sd = 0.01",
                          "dtau_rad_sd = 0.011", "phase_at_zero_rad = 0.4\nphase_at_zero_rad_sd = 1e-4"}) {
    campaign(platform, camera, {"", run + key}, part);
    EXPECT_TRUE(all.insert(fingerprint()).second) << key;
  }
  campaign(platform, camera, {"", "mm_per_px = 0.1\nmm_per_px_sd = 0.001"}, part);
  EXPECT_EQ(recording_of(campaign_, campaign_.runs[1]).camera.mm_per_px_sd, 0.001);
  campaign(platform, camera + "mm_per_px_sd = 0.002", {}, part + "diameter_mm_sd = 0.01");
  EXPECT_EQ(recording_of(campaign_, campaign_.runs[0]).camera.mm_per_px_sd, 0.002);
  EXPECT_EQ(recording_of(campaign_, campaign_.runs[0]).part.diameter_sd_mm, 0.01);
}

}  // namespace
}  // namespace tribotrack::apps
