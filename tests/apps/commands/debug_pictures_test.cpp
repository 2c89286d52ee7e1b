// track --debug DIR: a picture of every stage, and an index of them; track --explain: what each stage took.
#include <gmock/gmock.h>

#include <algorithm>
#include <set>

#include "apps/program.h"
#include "vision/frame_source.h"

namespace tribotrack::apps {
namespace {

using ::testing::HasSubstr;

class DebugPictures : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    render_slide("slide.cine", {.texture = 8});
  }
};

TEST_F(DebugPictures, EveryPictureOfTheIndexIsThereAndCanBeLookedAt) {
  const Outcome outcome = run("track slide.cine --mm-per-px 0.05 -o t.csv --debug pictures -q");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  ASSERT_EQ(run("track slide.cine --mm-per-px 0.05 -o plain.csv -q").exit_code, 0);
  EXPECT_EQ(content_of(in_folder("t.csv")), content_of(in_folder("plain.csv")))
      << "looking changes no result";
  EXPECT_EQ(content_of(in_folder("t.csv.meta.json")), content_of(in_folder("plain.csv.meta.json")));
  std::istringstream index(content_of(in_folder("pictures/index.txt")));
  std::string line;
  std::getline(index, line);
  EXPECT_EQ(line, "file\tshows\tframe\tlow\thigh\tunit\tpx_per_pixel");
  std::set<std::string> listed;
  while (std::getline(index, line)) {
    ASSERT_EQ(std::ranges::count(line, '\t'), 6) << line;
    const std::string file = line.substr(0, line.find('\t'));
    listed.insert(file);
    EXPECT_GE(vision::open_source(in_folder("pictures/" + file))->read(0).width(), 700) << line;
  }
  for (const char* name : {"first_pass_template.png", "frame000039_first_pass_residual.png",
                           "layers_part.png", "frame000020_layers_predicted.png"})
    EXPECT_TRUE(listed.contains(name)) << name;
  std::size_t files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(in_folder("pictures")))
    files += entry.is_regular_file();
  EXPECT_EQ(files, listed.size() + 1);
}

TEST_F(DebugPictures, ExplainTellsTimesAndMetaNone) {
  const Outcome outcome = run("track slide.cine --mm-per-px 0.05 -o t.csv --layers off --explain -q");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("time of each stage"));
  EXPECT_THAT(outcome.err, HasSubstr("first pass: part"));
  const std::string text = content_of(in_folder("t.csv.meta.json"));
  EXPECT_EQ(text.find("first pass: part"), std::string::npos) << "times are volatile: run.json only";
}

}  // namespace
}  // namespace tribotrack::apps
