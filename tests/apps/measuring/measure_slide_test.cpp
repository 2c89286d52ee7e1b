// `measure` on the track of a part that slides freely.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>

#include "apps/program.h"
#include "apps/text/json.h"
#include "fit/free_slides.h"

namespace tribotrack::apps {
namespace {

using testing::HasSubstr;

class MeasureSlide : public ProgramTest {
 protected:
  void put_track(double ratio, bool with_angle) const {
    std::mt19937 random(3);
    const fit::TrajectoryRun run = test::slide_track(test::UnitSlide(ratio), ratio, {}, random, with_angle);
    std::string csv = "frame,time_s,status,x_mm,y_mm,sigma_x_mm,sigma_y_mm,theta_rad,sigma_theta_rad\n";
    for (std::size_t i = 0; i < run.track.time.size(); ++i) {
      csv += fmt::format("{},{},ok,{},{},0.03,0.03,", run.track.frame[i], run.track.time[i],
                         1e3 * run.track.position[i].x(), 1e3 * run.track.position[i].y());
      csv += with_angle ? fmt::format("{},0.01\n", run.track.angle[i]) : ",\n";
    }
    put(in_folder("slide.csv"), csv);
    put(in_folder("slide.csv.meta.json"),
        R"({"scale": {"mm_per_px": 0.5, "mm_per_px_sd": 0.0005}, "summary": {"disc_px": [10, 10, 31]}})");
  }
};

TEST_F(MeasureSlide, DecelerationStopAndSpin) {
  put_track(1.0, true);
  const Outcome outcome = run("measure slide.csv --json -o m.json");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const Json m = Json::parse(outcome.out);
  EXPECT_EQ(m["kind"], "free_slide");
  const double sd = m["deceleration_mm_s2_sd"];
  EXPECT_NEAR(m["deceleration_mm_s2"], 0.17 * 9810, 4 * sd);
  EXPECT_GT(sd, 0.9e-3 * 0.17 * 9810) << "the scale's 0.1 % is counted";
  EXPECT_NEAR(m["speed_mm_s"], 600, 3);
  EXPECT_NEAR(m["spin_ratio"], 1, 0.02);
  EXPECT_TRUE(m["stop_seen"].get<bool>());
  EXPECT_NEAR(m["stop_time_s"], 0.7 + test::UnitSlide(1.0).stop_time() * 0.6 / (0.17 * 9.81), 0.003);
  EXPECT_EQ(m["blows"].size(), 0u);
  EXPECT_TRUE(std::filesystem::exists(in_folder("m.json.meta.json")));
}

TEST_F(MeasureSlide, SpinNotSeenIsSaid) {
  put_track(0.0, false);
  const Outcome outcome = run("measure slide.csv --free-slide --gravity-m-s2 9.80");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("deceleration    166"));
  EXPECT_THAT(outcome.out, HasSubstr("g = 9.8 m/s^2"));
  EXPECT_THAT(outcome.out, HasSubstr("not seen; a rim speed of half the slide's would make mu1"));
}

}  // namespace
}  // namespace tribotrack::apps
