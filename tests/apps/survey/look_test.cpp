// `probe` with a picture and a page, and `init --from`, on rendered recordings.
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "apps/browser.h"
#include "apps/program.h"

namespace tribotrack::apps {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using Json = nlohmann::json;

std::string scene(const std::string& more = "") {
  return "[platform]\namplitude_mm = 0.28\nangular_frequency_rad_s = 62.8\nphase_shift_rad = \"pi/2\"\n"
         "[friction]\nmu1 = 0.1\nmu2 = 0.0125\nlag_rad = 0.2\nphi_rad = 0\ndtau_rad = \"pi/3\"\n"
         "[video]\nwidth = 180\nheight = 160\nframe_rate_hz = 250\nexposure_s = 0.4e-3\nframes = 60\n"
         "[camera]\nmm_per_px = 0.15\n[disc]\ndiameter_mm = 6\n"
         "[marker]\nposition_px = [30, 30]\nradius_px = 9\n" +
         more;
}

class Look : public ProgramTest {
 protected:
  void film(const std::string& name, const std::string& more = "") {
    put(in_folder("scene.toml"), scene(more));
    const Outcome outcome = run("synth scene.toml -q -o " + name);
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  }
};

TEST_F(Look, ProbeWritesPicturePageAndTheLinesToPaste) {
  film("a.cine", "[lamp]\nposition_px = [150, 20]\nradius_px = 5\n");
  const Outcome outcome = run("probe a.cine --picture first.png --page first.html");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, AllOf(HasSubstr("disc 1: the part"), HasSubstr("a mark on the platform"),
                                 HasSubstr("[camera]\n"), HasSubstr("disc_px = ["),
                                 HasSubstr("marker_px = ["), HasSubstr("gate_px = [150")));
  EXPECT_EQ(content_of(in_folder("first.png")).substr(1, 3), "PNG");
  EXPECT_THAT(content_of(in_folder("first.html")), Not(HasSubstr("http://"))) << "the page asks nobody";
}

using LookInChromium = Look;

TEST_F(LookInChromium, ThePageWorks) {
  const auto program = test::chromium();
  if (!program) GTEST_SKIP() << "no Chromium";
  film("a.cine");
  ASSERT_EQ(run("probe a.cine --page first.html").exit_code, 0);
  test::DrivenBrowser browser(*program);
  browser.open_page("file://" + in_folder("first.html").string());
  EXPECT_TRUE(browser.wait_for("document.body.innerText.includes('marker_px = [')"))
      << "the script has written the lines: " << browser.value("return document.body.innerText");
  EXPECT_EQ(browser.value("return document.documentElement.dataset.errors"), "0");
}

TEST_F(Look, InitFromAFolderIsACampaignThatRuns) {
  std::filesystem::create_directory(in_folder("recordings"));
  film("recordings/phi000_dtau060.cine");
  film("recordings/phi090_dtau060.cine");
  put(in_folder("recordings/notes.txt"), "not a recording");
  const Outcome made = run("init lab --from recordings --disc-diameter-mm 6");
  ASSERT_EQ(made.exit_code, 0) << made.err;
  const std::string campaign = content_of(in_folder("lab/campaign.toml"));
  EXPECT_THAT(campaign, AllOf(HasSubstr("video = \"../recordings/phi090_dtau060.cine\""),
                              HasSubstr("phi_rad = \"90deg\""), HasSubstr("dtau_rad = \"60deg\""),
                              HasSubstr("marker_px = ["), HasSubstr("# guess")));
  const Outcome plan = run("run lab/campaign.toml -o out --dry-run");
  EXPECT_EQ(plan.exit_code, 0) << plan.err;
  EXPECT_THAT(plan.out,
              AllOf(HasSubstr("phi000_dtau060"), HasSubstr("phi090_dtau060"), Not(HasSubstr("cannot"))));
}

// What the list says stands against what names and pictures suggest, and each name is looked for in the
// folder.
TEST_F(Look, AListSaysWhatNamesDoNot) {
  std::filesystem::create_directory(in_folder("recordings"));
  for (const char* name : {"IMG_2041", "IMG_2042", "slide3"})
    film(std::string("recordings/") + name + ".cine");
  put(in_folder("runs.csv"),
      "file;phi "
      "(\u00b0);dtau;name;cycles;by\nimg_2042;22,5;60\u00b0;second;12;me\nC:\\lab\\SLIDE3.CINE;0;pi/"
      "3;;;me\n");
  const Outcome made = run("init lab --from recordings --list runs.csv --disc-diameter-mm 6");
  ASSERT_EQ(made.exit_code, 0) << made.err;
  EXPECT_THAT(made.err, AllOf(HasSubstr("left out: no line of the list names IMG_2041.cine"),
                              Not(HasSubstr("to fill in"))));
  const std::string campaign = content_of(in_folder("lab/campaign.toml"));
  EXPECT_THAT(
      campaign,
      AllOf(HasSubstr("[[run]]\nvideo = \"../recordings/IMG_2042.cine\"\nname = \"second\"\nphi_rad = "
                      "\"22.5deg\"\ndtau_rad = \"60deg\"\ncycles = 12\n"),
            HasSubstr("slide3.cine\"\nphi_rad = \"0deg\"\ndtau_rad = \"pi/3\"\n"), HasSubstr("#:schema "),
            HasSubstr("\nmarker_px = [")));
  EXPECT_EQ(run("run lab --dry-run").exit_code, 0);
  put(in_folder("runs.csv"), "video,phi_deg,dtau_deg\nIMG_2041.cine,0,60\nIMG_2050.cine,0,60\n");
  expect_refused(run("init other --from recordings --list runs.csv"), 3,
                 {"runs.csv:3 (IMG_2050.cine)", "no line names IMG_2042.cine, slide3.cine"});
  EXPECT_FALSE(std::filesystem::exists(in_folder("other")));
}

TEST_F(Look, WhatIsNotKnownIsLeftToFillInAndSaid) {
  std::filesystem::create_directory(in_folder("recordings"));
  film("recordings/one.avi");
  put(in_folder("recordings/torn.cine"), "CI");
  const Outcome made = run("init lab --from recordings");
  EXPECT_EQ(made.exit_code, 0) << made.err;
  EXPECT_THAT(made.err,
              AllOf(HasSubstr("left out"), HasSubstr("torn.cine"), HasSubstr("to fill in: diameter_mm"),
                    HasSubstr("phi_rad and dtau_rad of one")));
  EXPECT_THAT(content_of(in_folder("lab/campaign.toml")),
              AllOf(HasSubstr("# LEFT OUT"), HasSubstr("# TO FILL IN"), HasSubstr("# phi_rad = \"0deg\"")));
}

/// Whatever its file is called.
TEST_F(Look, APartThatCirclesIsDrivenThoughNoMarkShowsIt) {
  std::filesystem::create_directory(in_folder("recordings"));
  put(in_folder("scene.toml"),
      "[platform]\namplitude_mm = 0.28\nangular_frequency_rad_s = 62.8\nphase_shift_rad = \"pi/2\"\n"
      "[friction]\nmu1 = 0.1\nmu2 = 0.0125\nlag_rad = 0.2\nphi_rad = 0\ndtau_rad = \"pi/3\"\n"
      "[video]\nwidth = 130\nheight = 110\nframe_rate_hz = 250\nexposure_s = 0.4e-3\nframes = 200\n"
      "[camera]\nmm_per_px = 0.1\n[disc]\ndiameter_mm = 4\n");
  for (const char* name : {"IMG_0012", "slide3"})
    ASSERT_EQ(run(std::string("synth scene.toml -q -o recordings/") + name + ".cine").exit_code, 0);
  const Outcome made = run("init lab --from recordings --disc-diameter-mm 4");
  ASSERT_EQ(made.exit_code, 0) << made.err;
  const std::string campaign = content_of(in_folder("lab/campaign.toml"));
  EXPECT_THAT(campaign, Not(HasSubstr("\nkind = \"free_slide\"")));
  EXPECT_THAT(campaign, HasSubstr("# angular_frequency_rad_s = 62."));
  EXPECT_THAT(made.err, AllOf(HasSubstr("phi_rad and dtau_rad of IMG_0012"),
                              HasSubstr("phi_rad and dtau_rad of slide3"),
                              HasSubstr("angular_frequency_rad_s and amplitude_mm in [platform]")));
}

}  // namespace
}  // namespace tribotrack::apps
