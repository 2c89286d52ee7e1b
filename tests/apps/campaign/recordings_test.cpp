// Recordings of a campaign: a free slide on an incline, what of a track is kept, and scales that runs share.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>
#include <random>

#include "apps/campaign/compared_runs.h"
#include "apps/program.h"
#include "apps/recording/recording.h"
#include "apps/recording/track.h"
#include "apps/text/json.h"

namespace tribotrack::apps {

namespace {

using testing::HasSubstr;

using Slides = ProgramTest;

TEST_F(Slides, DownAnInclineGiveMu1WithTheSlopesError) {
  constexpr double kSlope = 0.4, kMu = 0.25, kSlopeSd = 0.003;
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0, 0.02);
  std::string text = "t_s,x_mm,y_mm,sigma_x_mm,sigma_y_mm\n";
  for (int k = 0; k < 200; ++k) {
    const double t = 0.004 * k,
                 way = 50 * t + 4905 * (std::sin(kSlope) - kMu * std::cos(kSlope)) * t * t;  // mm
    const double x = 0.8 * way + noise(random), y = -0.6 * way + noise(random);
    text += fmt::format("{:.4f},{:.5f},{:.5f},0.02,0.02\n", t, x, y);
  }
  put(in_folder("down.csv"), text);
  put(in_folder("c.toml"),
      "[[run]]\ntrack = \"down.csv\"\nkind = \"free_slide\"\nslope_rad = 0.4\nslope_rad_sd = 0.003\n");
  const Outcome done = run("run c.toml -o out");
  ASSERT_EQ(done.exit_code, 0) << done.err;
  const Json fit = Json::parse(content_of(in_folder("out/fit.json")));
  const Json& mu1 = fit["parameters"]["mu1"];
  const double of_slope = (1 + kMu * std::tan(kSlope)) * kSlopeSd;
  EXPECT_NEAR(mu1["estimate"].get<double>(), kMu, 2e-3);
  EXPECT_NEAR(mu1["sd"].get<double>(), of_slope, 0.1 * of_slope);
  EXPECT_EQ(fit["runs"][0]["slope_rad"].get<double>(), kSlope);
  EXPECT_THAT(done.out, HasSubstr("incline"));
  EXPECT_THAT(content_of(in_folder("out/report.html")), HasSubstr("incline of 0.4 rad"));
}

namespace fs = std::filesystem;

class TrackRecording : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    put(in_folder("scene.toml"),
        "[platform]\namplitude_mm = 0\n[friction]\nmu1 = 0.2\n[run]\nvelocity_x_mm_s = 100\n[video]\nwidth = "
        "160\nheight = 120\nframe_rate_hz = 1000\nframes = 20\n[camera]\nmm_per_px = 0.05\n[disc]\nradius_px "
        "= "
        "12\nscratches = 0\nhighlight = 0\n[surface]\ntexture_rms = 0\n");
    ASSERT_EQ(run("synth scene.toml -o a.cine -q").exit_code, 0);
    recording_.video = in_folder("a.cine");
    recording_.camera.mm_per_px = 0.05;
  }
  Recording recording_;
};

// The rendered disc has a sharp edge of 12 px, 1.2 mm across at 0.05 mm/px.
TEST_F(TrackRecording, ADiameterCountsTheChamferAndChecksAnotherScale) {
  const auto scale = [&](const std::string& options) {
    const Outcome outcome = run("track a.cine --disc-diameter-mm 1.2 -q -o t.csv " + options);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    const Json json = Json::parse(content_of(in_folder("t.csv.meta.json")))["scale"];
    return std::pair(json["mm_per_px"].get<double>(), json["mm_per_px_sd"].get<double>());
  };
  const auto [sharp, sharp_sd] = scale("--chamfer-mm 0");
  EXPECT_NEAR(sharp, 0.05, 0.0002);
  EXPECT_LT(sharp_sd, 0.0001);
  const auto [known, known_sd] = scale("--chamfer-mm 0.05");  // of 12 px one, of which half is seen
  EXPECT_NEAR(known / sharp, 12 / 12.5, 0.001);
  EXPECT_NEAR(known_sd / known, 1 / std::sqrt(8.0) / 12.5, 0.001);
  const auto [unknown, unknown_sd] = scale("");
  EXPECT_LT(std::abs(unknown - sharp), 2 * unknown_sd);
  EXPECT_GT(unknown_sd, known_sd / 2);
  EXPECT_THAT(run("track a.cine --disc-diameter-mm 1.2 -o t.csv").err, HasSubstr("chamfer_mm"));
  const std::string both = "track a.cine --mm-per-px 0.05 --chamfer-mm 0 -o t.csv --disc-diameter-mm ";
  EXPECT_THAT(run(both + "1.2").err, Not(HasSubstr("across")));
  EXPECT_THAT(run(both + "1.4").err, HasSubstr("1.2 mm across by the scale given"));
  EXPECT_EQ(run("track a.cine --mm-per-px 0.05 --chamfer-mm 0.1 -o t.csv").exit_code, 2);
  EXPECT_EQ(run(both + "1.2 --chamfer-mm 0.6").exit_code, 2);
}

// A recording that is still being copied must not be recorded as the one that was tracked.
TEST_F(TrackRecording, WhatAFileOfSettingsHoldsStaysBesideTheFlags) {
  put(in_folder("k.toml"),
      "[camera]\nmarker_px = [40, 40, 9]\ngate_px = [9, 9, 3]\ndisc_px = [80, 60, 12]\n[part]\ndiameter_mm = "
      "2\n");
  TrackChoices choices;
  choices.config = in_folder("k.toml").string();
  choices.keys["camera"]["xi_axis_rad"] = 0.1;
  const Recording recording = recording_of(recording_.video, choices);
  EXPECT_EQ(recording.options.marker.kind, vision::MarkerChoice::Kind::circle);
  EXPECT_EQ(recording.options.marker.circle.radius, 9);
  ASSERT_TRUE(recording.options.gate.has_value());
  EXPECT_EQ(recording.options.gate->radius, 3);
  EXPECT_EQ(recording.options.target.disc.radius, 12);
  EXPECT_EQ(recording.part.diameter_mm, 2.0);
}

TEST_F(TrackRecording, ARecordingThatChangesMeanwhileIsRefused) {
  recording_.options.progress = [&](std::int64_t, std::int64_t) {
    std::ofstream(in_folder("a.cine"), std::ios::app) << "more";
  };
  EXPECT_THAT(complaint_of([&] { tracked(checked(recording_), "t.csv"); }),
              HasSubstr("a.cine: changed while"));
}

TEST_F(TrackRecording, TheKeyIsThatOfWhatWasTracked) {
  Recording recording = tracked(checked(recording_), "t.csv");
  std::ofstream(in_folder("a.cine"), std::ios::app) << "more";
  write_track(in_folder("a.csv"), recording);
  EXPECT_EQ(why_outdated(in_folder("a.csv"), recording), std::nullopt);
  EXPECT_EQ(why_outdated(in_folder("a.csv"), checked(recording_)),
            "its recording or its settings have changed");
  // Of one that is so large that a sample is hashed, the time tells too.
  recording.inputs.front().hashed = "sample of 18.0 MiB";
  fs::last_write_time(in_folder("a.cine"), fs::last_write_time(in_folder("a.csv")) + std::chrono::seconds(1));
  EXPECT_EQ(why_outdated(in_folder("a.csv"), recording), "its recording was written to after it");
}

using ::testing::AllOf;
using ::testing::IsEmpty;

/// Runs scaled by a part said to be 6 mm across. They hold no track: one that is measured again fails.
class SharedScales : public testing::Test {
 protected:
  SharedScales() { campaign_.part.diameter_mm = 6; }
  /// `size`: of the part that lies there, over 6 mm; `zoom`: px per mm over the others'.
  void add(double size, double zoom = 1) {
    CampaignRun run;
    run.name = "run" + std::to_string(campaign_.runs.size());
    run.place = "c.toml:1:1";
    campaign_.runs.push_back(run);
    apps::Run analysed;
    analysed.track.emplace();
    analysed.track->mm_per_px = 0.1 / (size * zoom);
    analysed.track->mm_per_px_sd = 1e-5;
    analysed.track->scale_source = "part's diameter";
    analysed.track->table.time = {static_cast<double>(runs_.size())};  // none is another's repetition
    analysed.track->table.position = {{0, 0}};
    analysed.measurement.emplace();
    analysed.measurement->platform.emplace();
    analysed.measurement->platform->amplitude.value = 0.28e-3 / size;
    runs_.push_back(std::move(analysed));
  }
  std::string failure_of_first() {
    for (std::size_t k = 0; k < runs_.size(); ++k) runs_[k].given = campaign_.runs[k];
    share_scale(campaign_, runs_);
    return runs_.front().failure;
  }
  Campaign campaign_;
  std::vector<apps::Run> runs_;
};

TEST_F(SharedScales, ARunWithAnotherPartIsNamedWithItsSize) {
  add(2.0 / 3);
  for (int k = 0; k < 3; ++k) add(1);
  EXPECT_THAT(failure_of_first(),
              AllOf(HasSubstr("run0"), HasSubstr("4 mm across, not 6 mm"), HasSubstr("mm_per_px")));
}

TEST_F(SharedScales, ACameraThatWasMovedIsNoOtherPart) {
  add(1, 1.5);
  for (int k = 0; k < 3; ++k) add(1);
  EXPECT_THAT(failure_of_first(), IsEmpty());
}

TEST_F(SharedScales, OfTwoPartsNobodyKnowsWhichIsTheOther) {
  add(2.0 / 3);
  add(1);
  EXPECT_THAT(failure_of_first(), testing::Not(HasSubstr("another part")));
}

}  // namespace

}  // namespace tribotrack::apps
