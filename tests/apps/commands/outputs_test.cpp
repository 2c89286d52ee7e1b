// What a command writes never replaces what it reads, another's work, or something that is no file.
#include <gmock/gmock.h>
#include <sys/stat.h>

#include <nlohmann/json.hpp>

#include "apps/program.h"

namespace tribotrack::apps {
namespace {

using ::testing::HasSubstr;
using Json = nlohmann::json;

const std::string kScene =
    "[platform]\namplitude_mm = 0\n[friction]\nmu1 = 0.2\n[run]\nvelocity_x_mm_s = 100\nvelocity_y_mm_s = "
    "40\n"
    "[video]\nwidth = 160\nheight = 120\nframe_rate_hz = 1000\nexposure_s = 0.2e-3\nframes = 40\n"
    "[camera]\nmm_per_px = 0.05\n[disc]\nradius_px = 12\nscratches = 0\nhighlight = 0\n"
    "[surface]\ntexture_rms = 0\n";

const std::string kCampaign =
    "[platform]\namplitude_mm = 0\n[camera]\nmm_per_px = 0.05\n[fit]\nparameters = [\"mu1\"]\n"
    "[[run]]\nvideo = \"slide.cine\"\nkind = \"free_slide\"\n";

class Outputs : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    put(in_folder("scene.toml"), kScene);
    put(in_folder("c.toml"), kCampaign);
    ASSERT_EQ(run("synth scene.toml -o slide.cine -q").exit_code, 0);
    video_ = content_of(in_folder("slide.cine"));
  }
  /// Exit 3 with one sentence, and every named file as it was.
  void expect_kept(const std::string& command, const std::string& file, const std::string& word) {
    const std::string before = content_of(in_folder(file));
    expect_refused(run(command), 3, {word});
    EXPECT_EQ(content_of(in_folder(file)), before) << command;
  }
  std::string video_;
};

TEST_F(Outputs, AnInputIsNeverWrittenOver) {
  const std::string track = "track slide.cine --mm-per-px 0.05 -q -o ";
  expect_kept(track + "slide.cine", "slide.cine", "slide.cine");
  std::filesystem::create_hard_link(in_folder("slide.cine"), in_folder("hard.csv"));
  expect_kept(track + "hard.csv", "hard.csv", "is an input");
  std::filesystem::create_symlink("slide.cine", in_folder("soft.csv"));
  expect_kept(track + "soft.csv", "slide.cine", "is an input");
  expect_kept("track slide.cine --mm-per-px 0.05 -q -o t.csv --overlay ./slide.cine", "slide.cine",
              "is an input");
  EXPECT_EQ(content_of(in_folder("slide.cine")), video_);

  ASSERT_EQ(run(track + "t.csv").exit_code, 0);
  expect_kept("measure t.csv --omega-rad-s 62.8 -o t.csv", "t.csv", "is an input");
  std::filesystem::create_directory(in_folder("tracks"));
  ASSERT_EQ(run(track + "tracks/slide.csv").exit_code, 0);
  expect_kept("fit c.toml --tracks tracks -o c.toml -q", "c.toml", "is an input");
  expect_kept("fit c.toml --tracks tracks -o tracks/slide.csv -q", "tracks/slide.csv", "is an input");
  put(in_folder("s.toml"), "[friction]\nmu1 = 0.1\n[sweep]\nover = [\"phi_rad=0:1:3\"]\n");
  expect_kept("simulate s.toml -o s.toml", "s.toml", "is an input");
  expect_kept("sweep s.toml -o s.toml", "s.toml", "is an input");
  expect_kept("synth scene.toml -o scene.toml", "scene.toml", "is an input");

  ASSERT_EQ(run("run c.toml -o out -q").exit_code, 0);
  for (const char* file : {"out/fit.json", "out/fit.json.meta.json", "out/tracks/slide.csv"})
    expect_kept(std::string("report out -q -o ") + file, file, "is an input");
  EXPECT_EQ(run("report out -q -o out/report.html").exit_code, 0);

  // A recording that lies where `run` keeps its videos.
  std::filesystem::create_directories(in_folder("mixed/tracks"));
  std::filesystem::copy_file(in_folder("slide.cine"), in_folder("mixed/tracks/slide.mp4"));
  put(in_folder("mixed.toml"), kCampaign.substr(0, kCampaign.find("slide.cine")) +
                                   "mixed/tracks/slide.mp4\"\nkind = \"free_slide\"\n");
  expect_kept("run mixed.toml -o mixed --overlay-videos -q", "mixed/tracks/slide.mp4", "is an input");
}

TEST_F(Outputs, TwoOutputsAreTwoFiles) {
  expect_refused(run("track slide.cine --mm-per-px 0.05 -o t.html --overlay ./t.html -q"), 3,
                 {"two outputs"});
  expect_refused(run("track slide.cine --mm-per-px 0.05 -o t.png --overlay t.png -q"), 3, {"t.png"});
  EXPECT_FALSE(std::filesystem::exists(in_folder("t.html")));
  EXPECT_FALSE(std::filesystem::exists(in_folder("t.png")));
}

TEST_F(Outputs, AResultDoesNotTakeTheNameOfARecording) {
  put(in_folder("other.CINE"), "somebody's only copy");
  expect_kept("track slide.cine --mm-per-px 0.05 -o other.CINE -q", "other.CINE", ".CINE");
  expect_kept("simulate -o other.CINE", "other.CINE", ".CINE");
  expect_refused(run("simulate -o new.mp4"), 3, {".mp4"});
  EXPECT_FALSE(std::filesystem::exists(in_folder("new.mp4")));
}

TEST_F(Outputs, WhatIsNoFileIsNotReplaced) {
  ASSERT_EQ(::mkfifo(in_folder("fifo.csv").c_str(), 0600), 0);
  expect_refused(run("simulate -o fifo.csv"), 3, {"fifo.csv", "fifo"});
  EXPECT_TRUE(std::filesystem::is_fifo(in_folder("fifo.csv")));
  // A link to a device instead of a device, so that no machine loses its /dev/full by this test.
  std::filesystem::create_symlink("/dev/full", in_folder("full.csv"));
  expect_refused(run("simulate -o full.csv"), 3, {"full.csv", "device"});
  EXPECT_TRUE(std::filesystem::is_symlink(in_folder("full.csv")));
  std::filesystem::create_directory(in_folder("folder"));
  expect_refused(run("simulate -o folder"), 3, {"folder"});
}

TEST_F(Outputs, ALinkIsFollowedAndStays) {
  put(in_folder("real.csv"), "old");
  std::filesystem::create_symlink("real.csv", in_folder("link.csv"));
  ASSERT_EQ(run("simulate -o link.csv -q").exit_code, 0);
  EXPECT_TRUE(std::filesystem::is_symlink(in_folder("link.csv")));
  EXPECT_EQ(content_of(in_folder("real.csv")).substr(0, 6), "time_s");
}

TEST_F(Outputs, StandardOutputTakesTheResultAlone) {
  ASSERT_EQ(run("simulate -o t.csv -q").exit_code, 0);
  const std::string table = content_of(in_folder("t.csv"));
  for (const char* name : {"-", "/dev/stdout"}) {
    const Outcome outcome = run(std::string("simulate -q -o ") + name);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_EQ(outcome.out, table);
  }
  EXPECT_EQ(run("track slide.cine --mm-per-px 0.05 -q -o -").out.substr(0, 6), "frame,");
  EXPECT_EQ(run("sweep --over phi_rad=0:1:3 -q -o -").out.substr(0, 8), "phi_rad,");
  EXPECT_TRUE(Json::parse(run("fit c.toml -q -o -").out).contains("parameters"));
  EXPECT_FALSE(std::filesystem::exists(in_folder("-")));
  EXPECT_FALSE(std::filesystem::exists(in_folder("-.meta.json")));
  expect_refused(run("simulate --json -o -"), 2, {"--json"});
  expect_refused(run("report out -o -"), 3, {"standard output"});
}

}  // namespace
}  // namespace tribotrack::apps
