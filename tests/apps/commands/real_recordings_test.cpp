// The program on recordings nobody here made. Skipped unless TRIBOTRACK_REAL_DATA names their folder.
#include <gmock/gmock.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "apps/program.h"

namespace tribotrack::apps {
namespace {

using ::testing::HasSubstr;
using Json = nlohmann::json;

class RealRecordings : public ProgramTest {
 protected:
  void SetUp() override {
    const char* folder = std::getenv("TRIBOTRACK_REAL_DATA");
    if (folder == nullptr) GTEST_SKIP() << "TRIBOTRACK_REAL_DATA is not set";
    real_ = std::filesystem::absolute(folder);
    ProgramTest::SetUp();
  }
  std::string real(const std::string& name) const { return "'" + (real_ / name).string() + "'"; }
  std::filesystem::path real_;
};

// A carrom man at rest until frame 188, struck, sliding to the right until it leaves the picture near frame
// 276. A hand and the striker cross the view, other men look like it.
TEST_F(RealRecordings, TheStruckManIsFollowedUntilItLeaves) {
  const Outcome outcome =
      run("track " + real("carrom/HeadOn.MP4") +
          " --fps 240 --disc 151,87,9 --disc-diameter-mm 31 --frames 188: -o head.csv --overlay head.png");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  std::istringstream table(content_of(in_folder("head.csv")));
  std::string line;
  std::getline(table, line);
  int ok = 0, last_ok = 0;
  double last_x = 0;
  while (std::getline(table, line)) {
    int frame = 0;
    double x = 0;
    if (std::sscanf(line.c_str(), "%d,%*[^,],%lf", &frame, &x) == 2) {
      ++ok;
      EXPECT_GE(x, last_x - 0.2) << "it never turns back: frame " << frame;
      EXPECT_LT(x - last_x, frame == 188 ? 200 : 6) << "nor jumps: frame " << frame;
      last_x = x;
      last_ok = frame;
    } else {
      EXPECT_THAT(line, ::testing::ContainsRegex("^[0-9]+,[0-9.]+,,,,,,,(lost|edge),,,,"));
    }
  }
  EXPECT_GE(ok, 84);
  EXPECT_NEAR(last_ok, 276, 4) << "seen again after it had left: a point was invented";
  EXPECT_GT(last_x, 290);
}

TEST_F(RealRecordings, ItsFrictionComesWithAnIntervalAndAReport) {
  put(in_folder("campaign.toml"),
      "[platform]\namplitude_mm = 0\n[part]\ndiameter_mm = 31\n[camera]\nframe_rate_hz = "
      "240\n[fit]\nparameters = [\"mu1\"]\n"
      "[[run]]\nvideo = \"" +
          (real_ / "carrom/HeadOn.MP4").string() +
          "\"\nkind = \"free_slide\"\nframes = [188, 290]\ndisc_px = [151, 87, 9]\n");
  const Outcome outcome = run("run campaign.toml -o out -q");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const Json mu1 = Json::parse(content_of(in_folder("out/fit.json")))["parameters"]["mu1"];
  // Deceleration of 890 px/s^2 by an independent look, 31 mm over 17 to 18 px: 0.156 to 0.165.
  EXPECT_NEAR(mu1["estimate"], 0.16, 0.01);
  EXPECT_LT(mu1["ci95"][0], 0.1625);
  EXPECT_GT(mu1["ci95"][1], 0.1655);
  EXPECT_LT(mu1["sd"], 0.01);
  EXPECT_THAT(content_of(in_folder("out/report.html")), HasSubstr("Free slides"));
}

TEST_F(RealRecordings, CineFilesTellSizeDepthRateAndStamps) {
  struct Expected {
    const char* file;
    int width, height, bits, frames, first;
    double rate;
  };
  for (const Expected& e : {Expected{"phantom_v1610.cine", 256, 128, 8, 6, -85, 100},
                            {"phantom_v611_raw_16bpp.cine", 256, 128, 12, 6, 151325, 2000},
                            {"packed_12bpp.cine", 256, 128, 12, 6, 60, 100},
                            {"twente_p10_235frames.cine", 256, 32, 12, 235, 0, 100}}) {
    const Json info = Json::parse(run("probe " + real(std::string("cine/") + e.file) + " --json").out);
    EXPECT_EQ(info["width_px"], e.width) << e.file;
    EXPECT_EQ(info["height_px"], e.height) << e.file;
    EXPECT_EQ(info["bits"], e.bits) << e.file;
    EXPECT_EQ(info["frames"], e.frames) << e.file;
    EXPECT_EQ(info["first_image"], e.first) << e.file;
    EXPECT_EQ(info["time_base"]["rate_hz"], e.rate) << e.file;
    EXPECT_EQ(info["time_base"]["stamps"], true) << e.file;
  }
  expect_refused(run("probe " + real("cine/invalid_color.cine")), 3, {"colour", "mosaic", "export"});
}

}  // namespace
}  // namespace tribotrack::apps
