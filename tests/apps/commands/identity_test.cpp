// What the program answers where it cannot know which disc is the part, or at which rate was recorded.
#include <gmock/gmock.h>

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "apps/program.h"
#include "vision/frame_sink.h"

namespace tribotrack::apps {
namespace {

using ::testing::HasSubstr;

class Identity : public ProgramTest {
 protected:
  /// Bright discs on a dark ground, 20 frames of 160 x 100 px.
  void record(const std::string& name, double rate_hz,
              const std::function<std::vector<vision::Circle>(int frame)>& discs) {
    vision::SinkOptions options;
    options.width = 160;
    options.height = 100;
    options.frame_rate_hz = rate_hz;
    const auto sink = vision::create_sink(in_folder(name), options);
    for (int k = 0; k < 20; ++k) {
      vision::Picture picture(160, 100);
      for (int y = 0; y < 100; ++y)
        for (int x = 0; x < 160; ++x) {
          double level = 50 + (7 * x + 13 * y + 5 * k) % 3;
          for (const vision::Circle& c : discs(k))
            level += 55 * std::erfc(std::hypot(x - c.x, y - c.y) - c.radius);
          picture.at(x, y) = static_cast<float>(std::round(level));
        }
      sink->write(picture);
    }
    sink->close();
  }
  void record_two(const std::string& name) {
    record(name, 500, [](int k) {
      return std::vector<vision::Circle>{{40.4 + k, 30.2, 11}, {120.2, 60.3 - 0.5 * k, 11.2}};
    });
  }
};

TEST_F(Identity, TwoDiscsAreAQuestionWithAPictureAndWhatToPaste) {
  record_two("two.cine");
  const Outcome asked = run("track two.cine --mm-per-px 0.1 -o t.csv -q");
  expect_refused(asked, 3,
                 {"2 discs in frame 0", "t.discs.png", "1: --disc 40.4,30.2,11", "2: --disc 120.2,60.3,11"});
  EXPECT_EQ(content_of(in_folder("t.discs.png")).substr(1, 3), "PNG");
  EXPECT_FALSE(std::filesystem::exists(in_folder("t.csv")));
  EXPECT_EQ(run("track two.cine --mm-per-px 0.1 --disc 40.4,30.2,11.0 -o t.csv -q").exit_code, 0);
}

TEST_F(Identity, ADiscThatNeverMovesIsNoPartUnlessItIsSaidToBe) {
  record("still.cine", 500, [](int) { return std::vector<vision::Circle>{{40.4, 30.2, 11}}; });
  const Outcome found = run("track still.cine --mm-per-px 0.1 -o t.csv -q");
  expect_refused(found, 4, {"never moves", "--disc 40.4,30.2,11"});
  EXPECT_TRUE(std::filesystem::exists(in_folder("t.csv")));
  EXPECT_EQ(run("track still.cine --mm-per-px 0.1 --disc 40.4,30.2,11 -o t.csv -q").exit_code, 0);
  put(in_folder("c.toml"), slides_campaign({"still.cine"}, "mm_per_px = 0.1\n"));
  expect_refused(run("run c.toml -o out -q"), 3, {"still", "never moves", "disc_px"});
}

TEST_F(Identity, APlaybackRateNeedsAReason) {
  record("slow.avi", 30, [](int k) { return std::vector<vision::Circle>{{40.4 + k, 30.2, 11}}; });
  const std::string track = "track slow.avi --mm-per-px 0.1 -o t.csv -q";
  expect_refused(run(track), 3, {"--fps"});
  expect_refused(run(track + " --fps 30"), 3, {"playback rate", "--fps-reason"});
  EXPECT_EQ(run(track + " --fps 240").exit_code, 0);
  ASSERT_EQ(run(track + " --fps 30 --fps-reason 'set on the camera'").exit_code, 0);
  EXPECT_THAT(content_of(in_folder("t.csv.meta.json")), HasSubstr("given by the user: set on the camera"));
  expect_refused(run(track + " --fps-reason x"), 2, {"--fps"});
}

}  // namespace
}  // namespace tribotrack::apps
