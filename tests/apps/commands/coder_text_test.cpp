// x264 writes its settings into the stream. Text there that names files, in the words of its option parser,
// stays text: nothing of it is given to an encoder.
#include <gmock/gmock.h>

#include "apps/program.h"

namespace tribotrack::apps {
namespace {

using ::testing::HasSubstr;

const std::string kScene =
    "[platform]\namplitude_mm = 0\n[friction]\nmu1 = 0.2\n[run]\nvelocity_x_mm_s = 100\n"
    "[video]\nwidth = 160\nheight = 120\nframe_rate_hz = 1000\nframes = 40\n"
    "[camera]\nmm_per_px = 0.05\n[disc]\nradius_px = 12\nscratches = 0\nhighlight = 0\n"
    "[surface]\ntexture_rms = 0\n";

std::string campaign(const std::string& camera) {
  return "[platform]\namplitude_mm = 0\n[camera]\n" + camera +
         "mm_per_px = 0.05\n[fit]\nparameters = [\"mu1\"]\n"
         "[[run]]\nvideo = \"coded.mp4\"\nkind = \"free_slide\"\n";
}

class CoderText : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    put(in_folder("scene.toml"), kScene);
    ASSERT_EQ(run("synth scene.toml -o coded.mp4 -q").exit_code, 0);
    put(in_folder("victim"), "somebody's work");
    std::string video = content_of(in_folder("coded.mp4"));
    const std::size_t begin = video.find("options: ");
    ASSERT_NE(begin, std::string::npos);
    const std::size_t end = video.find('\0', begin);
    std::string settings = "options: cabac=1:dump-yuv=" + in_folder("victim").string() +
                           " ref=3:pass=1:stats=" + in_folder("stats").string() + " deadzone=21,11 crf=18.0";
    ASSERT_LT(settings.size(), end - begin);
    settings.resize(end - begin, ' ');
    put(in_folder("coded.mp4"), video.replace(begin, settings.size(), settings));
    put(in_folder("c.toml"), campaign(""));
    put(in_folder("r.toml"), campaign("rehearse = true\n"));
  }
};

TEST_F(CoderText, NamesNoFileToWrite) {
  EXPECT_THAT(run("probe coded.mp4 --json").out, HasSubstr("dump-yuv"));
  EXPECT_EQ(run("track coded.mp4 --mm-per-px 0.05 -q -o t.csv").exit_code, 0);
  expect_refused(run("track coded.mp4 --mm-per-px 0.05 -q -o r.csv --rehearse"), 2,
                 {"film uncompressed or FFV1"});
  EXPECT_THAT(run("run c.toml -o out -q").exit_code, testing::AnyOf(0, 4, 5));
  expect_refused(run("run r.toml -o refused -q"), 3, {"rehearse", "film uncompressed or FFV1"});

  EXPECT_EQ(content_of(in_folder("victim")), "somebody's work");
  EXPECT_THAT(left_behind(), testing::UnorderedElementsAre("scene.toml", "c.toml", "r.toml", "coded.mp4",
                                                           "coded.mp4.meta.json", "coded.mp4.truth.csv",
                                                           "victim", "t.csv", "t.csv.meta.json", "out"));
}

}  // namespace
}  // namespace tribotrack::apps
