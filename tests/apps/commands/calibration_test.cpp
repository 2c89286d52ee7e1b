// Scale from a calibrated camera and between two planes, as a user gives it.
#include <gmock/gmock.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "apps/program.h"

namespace tribotrack::apps {
namespace {

using ::testing::HasSubstr;
using Json = nlohmann::json;

class Calibrated : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    render_slide("slide.cine");
  }
  /// A camera that looks straight down from 100 mm: 0.05 mm/px, distortion as given.
  void calibration(double k1, int width = 160) const {
    const Json json = {
        {"width_px", width},
        {"height_px", 120},
        {"mm_per_px", 0.05},
        {"mm_per_px_sd", 1e-5},
        {"camera_matrix", {{2000, 0, 79.5}, {0, 2000, 59.5}, {0, 0, 1}}},
        {"distortion", {{"k1", k1}, {"k2", 0}, {"p1", 0}, {"p2", 0}, {"k3", 0}}},
        {"plane", {{"rotation", {{1, 0, 0}, {0, -1, 0}, {0, 0, -1}}}, {"translation_mm", {0, 0, 100}}}}};
    put(in_folder("calibration.json"), json.dump());
  }
  /// x_mm of the track's last row.
  double last_x(const std::string& table) const {
    const std::string text = content_of(in_folder(table));
    const std::string row = text.substr(text.rfind('\n', text.size() - 2) + 1);
    double x = std::nan("");
    std::sscanf(row.c_str(), "%*[^,],%*[^,],%*[^,],%*[^,],%*[^,],%*[^,],%*[^,],%*[^,],%*[^,],%lf", &x);
    return x;
  }
};

TEST_F(Calibrated, ABentLensIsStraightened) {
  calibration(-20);  // (x/f)^2 is 1.6e-3 at the border: 3 % of distortion
  ASSERT_EQ(run("track slide.cine --mm-per-px 0.05 -o plain.csv -q").exit_code, 0);
  ASSERT_EQ(run("track slide.cine --calibration calibration.json -o t.csv -q").exit_code, 0);
  EXPECT_THAT(content_of(in_folder("t.csv")), HasSubstr("rho_xy_mm,marker_x_mm"));
  EXPECT_EQ(Json::parse(content_of(in_folder("t.csv.meta.json")))["scale"]["calibrated_camera"], true);
  EXPECT_GT(std::abs(last_x("t.csv") - last_x("plain.csv")), 1e-3);
  const Outcome measured = run("measure t.csv --omega-rad-s 1000 --json -q");
  EXPECT_EQ(measured.exit_code, 4) << "the part slides on a platform at rest: it has no cycles";
  EXPECT_TRUE(Json::parse(measured.out).contains("v_mm_s"));
}

TEST_F(Calibrated, ACampaignNamesIt) {
  calibration(-20);
  put(in_folder("campaign.toml"),
      "[part]\nheight_mm = 0.8\n" + slides_campaign({"slide.cine"}, "calibration = \"calibration.json\"\n"));
  const Outcome outcome = run("run campaign.toml -o out");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const Json meta = Json::parse(content_of(in_folder("out/tracks/slide.csv.meta.json")));
  EXPECT_EQ(meta["scale"]["calibrated_camera"], true);
  // Another calibration, another track.
  calibration(-10);
  EXPECT_THAT(run("run campaign.toml -o out --dry-run").out, HasSubstr("track again, measure"));
}

TEST_F(Calibrated, AStraightLensIsAScale) {
  calibration(0);
  ASSERT_EQ(run("track slide.cine --mm-per-px 0.05 -o plain.csv -q").exit_code, 0);
  const Outcome outcome = run("track slide.cine --calibration calibration.json -o t.csv --explain");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_NEAR(last_x("t.csv") / last_x("plain.csv"), 1, 1e-6);
  EXPECT_THAT(outcome.err, HasSubstr("lens and tilt"));
  const Json meta = Json::parse(content_of(in_folder("t.csv.meta.json")));
  EXPECT_EQ(meta["scale"]["source"], "calibration");
  EXPECT_EQ(meta["scale"]["mm_per_px_sd"], 1e-5);
}

TEST_F(Calibrated, HeightAboveTheCalibratedPlaneMakesLengthsShorter) {
  calibration(0);
  ASSERT_EQ(run("track slide.cine --mm-per-px 0.05 -o plain.csv -q").exit_code, 0);
  for (const char* scale : {"--calibration calibration.json", "--mm-per-px 0.05 --working-distance-mm 100"}) {
    const Outcome outcome = run(std::string("track slide.cine --height-mm 2 -o t.csv --explain ") + scale);
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_NEAR(last_x("t.csv") / last_x("plain.csv"), 0.98, 1e-6) << scale;
  }
  // By its own diameter the part's top needs no correction, and there is no marker below.
  ASSERT_EQ(run("track slide.cine --disc-diameter-mm 1.2 -o plain.csv -q").exit_code, 0);
  ASSERT_EQ(run("track slide.cine --disc-diameter-mm 1.2 --height-mm 2 --working-distance-mm 100 -o t.csv -q")
                .exit_code,
            0);
  EXPECT_EQ(last_x("t.csv"), last_x("plain.csv"));
}

}  // namespace
}  // namespace tribotrack::apps
