#include "apps/files/campaign/campaign.h"

#include <gmock/gmock.h>

#include <numbers>

#include "apps/program.h"
#include "apps/program/errors.h"

namespace tribotrack::apps {
namespace {

using ::testing::HasSubstr;

constexpr double pi = std::numbers::pi;

class CampaignTest : public ProgramTest {
 protected:
  Campaign read(const std::string& text) {
    put(in_folder("c.toml"), text);
    return read_campaign(in_folder("c.toml"));
  }
  std::string complaint(const std::string& text) {
    return complaint_of([&] { read(text); });
  }
};

const std::string kRun =
    "[[run]]\nphi_rad = 0\ndtau_rad = 1\nalpha_rad = 1\nalpha_sd_rad = 0.1\nv_mm_s = 2\nv_sd_mm_s = 0.1\n";

TEST_F(CampaignTest, RunsTakeWhatTheyDoNotSayFromTheTablesAboveThem) {
  const Campaign c = read(R"(
[platform]
amplitude_mm = 0.28
phase_shift_rad = "pi/2"
[fit]
parameters = ["mu1", "mu2", "phase_lag_rad", "tilt_x_rad", "amplitude_mm"]
start = "circling"
cycles = 18
[fit.fixed]
delay_s = 1e-4
[fit.guess]
phase_lag_rad = "pi/8"
[fit.prior]
amplitude_mm = { mean = 0.28, sd = 0.001 }
[camera]
mm_per_px = 0.02
[[run]]
video = "phi000_dtau060.cine"
phi_rad = 0
dtau_rad = "pi/3"
amplitude_mm = 0.29
start = "steady"
start_phase_rad = "pi/4"
cycles = 10
frames = [3, 500]
name = "first"
[[run]]
phi_rad = 0
dtau_rad = "pi/6"
alpha_rad = 5.93
alpha_sd_rad = 0.02
v_mm_s = 1.78
v_sd_mm_s = 0.04
[[run]]
video = "free_slide.mp4"
kind = "free_slide"
)");
  EXPECT_DOUBLE_EQ(*c.platform.amplitude, 0.28e-3);
  EXPECT_DOUBLE_EQ(*c.platform.phase_shift, pi / 2);
  EXPECT_EQ(c.fit.parameters.size(), 5u);
  EXPECT_EQ(c.fit.parameters[3], fit::FitParameter::tilt_x);
  EXPECT_DOUBLE_EQ(c.fit.guess.at(fit::FitParameter::lag), pi / 8);
  EXPECT_DOUBLE_EQ(c.fit.fixed.at(fit::FitParameter::delay), 1e-4);
  EXPECT_DOUBLE_EQ(c.fit.prior.at(fit::FitParameter::amplitude).sd, 0.001);
  ASSERT_EQ(c.runs.size(), 3u);
  EXPECT_EQ(c.runs[0].name, "first");
  EXPECT_EQ(c.runs[0].video, in_folder("phi000_dtau060.cine"));
  EXPECT_EQ(c.runs[0].start, model::Start::steady);
  EXPECT_EQ(c.runs[0].cycles, 10);
  EXPECT_EQ(c.runs[0].first_frame, 3);
  EXPECT_DOUBLE_EQ(*c.runs[0].amplitude, 0.29e-3);
  EXPECT_EQ(c.runs[1].name, "run02");
  EXPECT_EQ(c.runs[1].start, model::Start::circling);
  EXPECT_EQ(c.runs[1].cycles, 18);
  EXPECT_DOUBLE_EQ(*c.runs[1].v, 1.78e-3);
  EXPECT_TRUE(c.runs[2].free_slide);
  EXPECT_EQ(c.runs[2].name, "free_slide");
  EXPECT_TRUE(c.warnings.empty());
}

TEST_F(CampaignTest, WhatNoLaboratoryHasIsRefused) {
  EXPECT_THAT(complaint("[platform]\namplitude_y_mm = 1e150\n" + kRun),
              HasSubstr("c.toml:2:1: `amplitude_y_mm` in [platform] cannot be 1e+150: nothing here has more "
                        "than 1e+06 mm"));
  EXPECT_THAT(complaint("[platform]\nfrequency_hz = 1e30\n" + kRun), HasSubstr("more than 1e+10 Hz"));
  EXPECT_THAT(complaint("[platform]\ngravity_m_s2 = 9.81\ngravity_m_s2_sd = 1e9\n" + kRun),
              HasSubstr("m/s2"));
  EXPECT_THAT(complaint(kRun + "name = \"a\\u0000b\"\n"),
              HasSubstr("the name \"a?b\" holds a control character"));
}

TEST_F(CampaignTest, AnSdWithoutUseIsRefused) {
  EXPECT_THAT(
      complaint("[platform]\namplitude_mm_sd = 0.001\n" + kRun),
      HasSubstr("c.toml:2:1: `amplitude_mm_sd` in [platform] is the sd of `amplitude_mm`, which is not"));
  EXPECT_THAT(complaint("[platform]\ngravity_m_s2 = 9.81\ngravity_m_s2_sd = -1\n" + kRun),
              HasSubstr("c.toml:3:1: `gravity_m_s2_sd` in [platform] must be greater than 0, not -1"));
  EXPECT_THAT(complaint("[part]\nheight_mm = 1\nheight_mm_sd = 0.1\n" + kRun),
              HasSubstr("needs working_distance_mm"));
  EXPECT_THAT(complaint("[camera]\nworking_distance_mm = 100\nworking_distance_mm_sd = 1\n" + kRun),
              HasSubstr("needs height_mm"));
  EXPECT_THAT(complaint(kRun + "phase_at_zero_rad = 0\nphase_at_zero_rad_sd = 0.1\n"),
              HasSubstr("with a video"));
  EXPECT_THAT(complaint("[platform]\ntilt_x_rad = 0\ntilt_x_rad_sd = 0.001\n[fit]\nparameters = [\"mu1\", "
                        "\"tilt_x_rad\"]\n[fit.prior]\ntilt_x_rad = { mean = 0, sd = 0.1 }\n" +
                        kRun),
              HasSubstr("are the same knowledge"));
}

TEST_F(CampaignTest, FreeSlidesAloneFitMu1) {
  const std::string slide = "[camera]\nmm_per_px = 0.1\n[[run]]\nvideo = \"a.mp4\"\nkind = \"free_slide\"\n";
  EXPECT_EQ(read(slide).fit.parameters, std::vector{fit::FitParameter::mu1});
  EXPECT_EQ(read(slide + kRun).fit.parameters.size(), 3U);
  EXPECT_EQ(read("[fit]\nparameters = [\"mu1\", \"tilt_x_rad\"]\n" + slide).fit.parameters.size(), 2U);
}

TEST_F(CampaignTest, AnInclineIsAFreeSlides) {
  const std::string camera = "[camera]\nmm_per_px = 0.1\n";
  const Campaign c = read(camera +
                          "[[run]]\nvideo = \"a.mp4\"\nkind = \"free_slide\"\nslope_rad = \"-20deg\"\n"
                          "slope_rad_sd = 0.002\n");
  EXPECT_NEAR(*c.runs[0].slope, -20 * std::numbers::pi / 180, 1e-12);
  EXPECT_EQ(*c.runs[0].slope_sd, 0.002);
  EXPECT_THAT(complaint(camera + "[[run]]\nvideo = \"a.mp4\"\nphi_rad = 0\ndtau_rad = 1\nslope_rad = 0.3\n"),
              HasSubstr("free_slide"));
  EXPECT_THAT(complaint(camera + "[[run]]\nvideo = \"a.mp4\"\nkind = \"free_slide\"\nslope_rad = 30\n"),
              HasSubstr("30deg"));
}

const std::string kTwoParts =
    "[camera]\nmm_per_px = 0.1\n[[part]]\nname = \"silver\"\n[[part]]\nname = \"steel\"\ndisc_px = [9, 8, "
    "7]\n";

TEST_F(CampaignTest, SeveralPartsHaveCampaignsOfTheirOwn) {
  const Campaign c =
      read(kTwoParts +
           "[[run]]\nvideo = \"a.cine\"\nphi_rad = 0\ndtau_rad = 1\nparts = { silver = [1, 2, 3], steel = "
           "[4, 5, 60, 70] }\n[[run]]\nvideo = \"b.cine\"\nphi_rad = 0\ndtau_rad = 2\npart = "
           "\"steel\"\n");
  const std::vector<Campaign> parts = campaigns_by_part(c);
  ASSERT_EQ(parts.size(), 2U);
  EXPECT_EQ(parts[0].part.name, "silver");
  ASSERT_EQ(parts[0].runs.size(), 1U);
  EXPECT_EQ(parts[0].runs[0].target.disc.x, 1);
  ASSERT_EQ(parts[1].runs.size(), 2U);
  EXPECT_EQ(parts[1].runs[0].target.rectangle.width, 60);
  EXPECT_EQ(parts[1].runs[1].target.disc.radius, 7);
  EXPECT_EQ(campaign_of_part(c, "steel").runs.size(), 2U);
  EXPECT_THAT(complaint_of([&] { campaign_of_part(c, ""); }), HasSubstr("silver, steel"));
  EXPECT_THAT(complaint_of([&] { campaign_of_part(c, "copper"); }), HasSubstr("silver, steel"));
}

TEST_F(CampaignTest, MistakesAboutPartsAreNamed) {
  const std::string run = "[[run]]\nvideo = \"a.cine\"\nphi_rad = 0\ndtau_rad = 1\n";
  EXPECT_THAT(complaint(kTwoParts + run), HasSubstr("does not say where each part lies"));
  EXPECT_THAT(complaint(kTwoParts + run + "parts = { copper = [1, 2, 3] }\n"), HasSubstr("silver, steel"));
  EXPECT_THAT(complaint(kTwoParts + run + "part = \"steel\"\n"),
              HasSubstr("no [[run]] shows the part \"silver\""));
  EXPECT_THAT(complaint("[[part]]\ndiameter_mm = 6\n[[part]]\nname = \"b\"\n" + run),
              HasSubstr("has a `name`"));
  EXPECT_THAT(complaint("[[part]]\nname = \"b\"\n[[part]]\nname = \"b\"\n" + run), HasSubstr("taken"));
  EXPECT_THAT(complaint("[[part]]\nname = \"a/b\"\n[[part]]\nname = \"b\"\n" + run), HasSubstr("folder"));
  EXPECT_THAT(complaint(kTwoParts + run + "parts = { silver = [1, 2, 3] }\ndisc_px = [1, 2, 3]\n"),
              HasSubstr("so does `disc_px`"));
  EXPECT_THAT(complaint("[part]\ndiameter_mm = 6\n" + run + "part = \"x\"\n"),
              HasSubstr("no [[part]] of that name"));
}

TEST_F(CampaignTest, ATagIsAMarkAndSetsTheScale) {
  const std::string run = "[[run]]\nvideo = \"a.cine\"\nphi_rad = 0\ndtau_rad = 1\n";
  const Campaign c =
      read("[camera]\nmarker = \"tag:apriltag_36h11:3\"\ntag_mm = 8\ntag_mm_sd = 0.02\n" + run);
  EXPECT_EQ(c.camera.marker.dictionary, "apriltag_36h11");
  EXPECT_EQ(*c.camera.marker.id, 3);
  EXPECT_EQ(*c.camera.tag_mm, 8);
  const auto said = [&](const std::string& camera) { return complaint("[camera]\n" + camera + run); };
  EXPECT_THAT(said("marker = \"tag:36h11\"\n"), HasSubstr("apriltag_36h11"));
  EXPECT_THAT(said("marker = \"tag:4x4_50:x\"\n"), HasSubstr("whole number"));
  EXPECT_THAT(said("marker = \"textur\"\n"), HasSubstr("texture"));
  EXPECT_THAT(said("tag_mm = 8\n"), HasSubstr("say which"));
  EXPECT_THAT(said("marker = \"tag:4x4_50\"\ntag_mm = 8\nmm_per_px = 0.1\n"), HasSubstr("leave one out"));
  EXPECT_THAT(said("marker = \"tag:4x4_50\"\nmarker_px = [1, 2, 3]\n"), HasSubstr("two marks"));
}

TEST_F(CampaignTest, ATraceMayStandInTwoFiles) {
  const std::string run = "[camera]\nmm_per_px = 1\n[[run]]\nvideo = \"a.cine\"\nphi_rad = 0\ndtau_rad = 1\n";
  const Campaign c = read(run + "scope = [\"ch1.csv\", \"ch2.csv\"]\n");
  EXPECT_EQ(c.runs[0].scope->filename(), "ch1.csv");
  EXPECT_EQ(c.runs[0].second_scope->filename(), "ch2.csv");
  EXPECT_THAT(complaint(run + "scope = [\"1\", \"2\", \"3\"]\n"), HasSubstr("one file, or two"));
}

}  // namespace
}  // namespace tribotrack::apps
