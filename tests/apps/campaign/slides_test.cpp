// Free slides of a campaign: on an incline, and where the part does not slide at all.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>
#include <random>

#include "apps/program.h"
#include "apps/text/json.h"

namespace tribotrack::apps {
namespace {

using testing::HasSubstr;

class Slides : public ProgramTest {
 protected:
  /// Positions by a closed form at 250 Hz with an error of 0.02 mm.
  template <class Way>
  void write_track(const std::string& name, const Way& way_mm) {
    std::mt19937 random(3);
    std::normal_distribution<double> noise(0, 0.02);
    std::string text = "t_s,x_mm,y_mm,sigma_x_mm,sigma_y_mm\n";
    for (int k = 0; k < 200; ++k)
      text += fmt::format("{:.4f},{:.5f},{:.5f},0.02,0.02\n", 0.004 * k,
                          0.8 * way_mm(0.004 * k) + noise(random), -0.6 * way_mm(0.004 * k) + noise(random));
    put(in_folder(name), text);
  }
};

TEST_F(Slides, DownAnInclineGiveMu1WithTheSlopesError) {
  constexpr double kSlope = 0.4, kMu = 0.25, kSlopeSd = 0.003;
  write_track("down.csv", [](double t) {
    return 1e3 * (0.05 * t + 0.5 * 9.81 * (std::sin(kSlope) - kMu * std::cos(kSlope)) * t * t);
  });
  put(in_folder("c.toml"),
      "[[run]]\ntrack = \"down.csv\"\nkind = \"free_slide\"\nslope_rad = 0.4\nslope_rad_sd = 0.003\n");
  const Outcome done = run("run c.toml -o out");
  ASSERT_EQ(done.exit_code, 0) << done.err;
  const Json fit = Json::parse(content_of(in_folder("out/fit.json")));
  const Json& mu1 = fit["parameters"]["mu1"];
  const double of_slope = (1 + kMu * std::tan(kSlope)) * kSlopeSd;
  EXPECT_NEAR(mu1["estimate"].get<double>(), kMu, 2e-3);
  EXPECT_NEAR(mu1["sd"].get<double>(), of_slope, 0.1 * of_slope);
  EXPECT_EQ(fit["runs"][0]["slope_rad"].get<double>(), kSlope);
  EXPECT_THAT(done.out, HasSubstr("incline"));
  EXPECT_THAT(content_of(in_folder("out/report.html")), HasSubstr("incline of 0.4 rad"));
}

TEST_F(Slides, OfAPartThatRestsAreNone) {
  write_track("rest.csv", [](double) { return 0.0; });
  put(in_folder("c.toml"), "[[run]]\ntrack = \"rest.csv\"\nkind = \"free_slide\"\n");
  const Outcome none = run("run c.toml -o out");
  EXPECT_EQ(none.exit_code, 3);
  EXPECT_THAT(none.err, HasSubstr("does not slide"));
}

}  // namespace
}  // namespace tribotrack::apps
