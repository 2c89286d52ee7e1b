// What a command writes never replaces what it reads, another's work, or something that is no file.
#include <gmock/gmock.h>
#include <sys/stat.h>

#include "apps/program.h"

namespace tribotrack::apps {
namespace {

class Outputs : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    render_slide("slide.cine");
    put(in_folder("c.toml"), slides_campaign({"slide.cine"}));
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
  expect_kept("fit c.toml --tracks tracks -o tracks/slide.csv -q", "tracks/slide.csv", "is an input");
  put(in_folder("s.toml"), "[friction]\nmu1 = 0.1\n[sweep]\nover = [\"phi_rad=0:1:3\"]\n");
  expect_kept("simulate s.toml -o s.toml", "s.toml", "is an input");
  expect_kept("sweep s.toml -o s.toml", "s.toml", "is an input");
  expect_kept("synth scene.toml -o scene.toml", "scene.toml", "is an input");

  ASSERT_EQ(run("run c.toml -o out -q").exit_code, 0);
  for (const char* file : {"out/fit.json.meta.json", "out/tracks/slide.csv"})
    expect_kept(std::string("report out -q -o ") + file, file, "is an input");
  EXPECT_EQ(run("report out -q -o out/report.html").exit_code, 0);
}

TEST_F(Outputs, AResultDoesNotTakeTheNameOfARecording) {
  put(in_folder("other.CINE"), "somebody's only copy");
  expect_kept("track slide.cine --mm-per-px 0.05 -o other.CINE -q", "other.CINE", ".CINE");
  expect_kept("simulate -o other.CINE", "other.CINE", ".CINE");
  expect_refused(run("simulate -o new.mp4"), 3, {".mp4"});
  EXPECT_FALSE(std::filesystem::exists(in_folder("new.mp4")));
}

}  // namespace
}  // namespace tribotrack::apps
