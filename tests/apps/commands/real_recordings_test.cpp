// The program on recordings nobody here made. Skipped unless TRIBOTRACK_REAL_DATA names their folder.
#include <gmock/gmock.h>

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
  std::filesystem::path real_;
};

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

}  // namespace
}  // namespace tribotrack::apps
