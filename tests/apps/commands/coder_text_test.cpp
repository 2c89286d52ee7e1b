// x264 writes its settings into the stream. Text there that names files, in the words of its option parser,
// stays text: nothing of it is given to an encoder.
#include <gmock/gmock.h>

#include "apps/program.h"

namespace tribotrack::apps {
namespace {

using ::testing::HasSubstr;

class CoderText : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    render_slide("coded.mp4");
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
    put(in_folder("c.toml"), slides_campaign({"coded.mp4"}));
    put(in_folder("r.toml"), slides_campaign({"coded.mp4"}, "rehearse = true\nmm_per_px = 0.05\n"));
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
