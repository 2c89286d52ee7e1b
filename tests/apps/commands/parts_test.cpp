// Several [[part]] of one campaign: each has its own fit, folder and report.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include "apps/program.h"
#include "apps/text/json.h"
#include "fit/problem.h"
#include "model/alpha_v.h"
#include "model/trajectory.h"

namespace tribotrack::apps {
namespace {

using testing::HasSubstr;
using testing::Not;

class Parts : public ProgramTest {
 protected:
  /// alpha and v of runs of a part, without noise.
  static std::string runs_of(const std::string& part, double mu1, double mu2) {
    std::string text;
    for (const auto& [phi, dtau] : {std::pair{0.0, 1.0}, {0.8, 1.0}, {2.0, 1.6}, {4.0, 2.1}}) {
      model::Scenario s;
      s.friction = {mu1, mu2, phi, dtau, 0.2};
      const Eigen::Vector2d end = model::integrate(s).end().position;
      text += fmt::format(
          "[[run]]\npart = \"{}\"\nphi_rad = {}\ndtau_rad = {}\nalpha_rad = {:.12f}\nalpha_sd_rad = "
          "0.002\nv_mm_s = "
          "{:.12f}\nv_sd_mm_s = 0.004\n",
          part, phi, dtau, model::displacement_angle(end), 1e3 * end.norm() / s.end_time());
    }
    return text;
  }
  void write(const std::string& runs) {
    put(in_folder("campaign.toml"),
        "[platform]\namplitude_mm = 0.28\nangular_frequency_rad_s = 62.8\nphase_shift_rad = "
        "\"pi/2\"\n[[part]]\nname = "
        "\"silver\"\n[[part]]\nname = \"steel\"\n" +
            runs);
  }
};

TEST_F(Parts, EachHasItsOwnFit) {
  write(runs_of("silver", 0.1, 0.02) + runs_of("steel", 0.07, 0.03));
  const Outcome all = run("run campaign.toml -o out --json");
  ASSERT_EQ(all.exit_code, 0) << all.err;
  const Json json = Json::parse(all.out);
  EXPECT_NEAR(json["parts"]["silver"]["parameters"]["mu1"]["estimate"].get<double>(), 0.1, 1e-4);
  EXPECT_NEAR(json["parts"]["steel"]["parameters"]["mu1"]["estimate"].get<double>(), 0.07, 1e-4);
  for (const char* part : {"silver", "steel"})
    EXPECT_TRUE(std::filesystem::exists(in_folder("out") / part / "report.html")) << part;
  const std::string table = content_of(in_folder("out/parts.csv"));
  EXPECT_THAT(table, HasSubstr("\nsilver,mu1,0."));
  EXPECT_THAT(table, HasSubstr("\nsteel,phase_lag_rad,0."));

  const Outcome one = run("fit campaign.toml --part steel -o steel.json");
  ASSERT_EQ(one.exit_code, 0) << one.err;
  EXPECT_EQ(Json::parse(content_of(in_folder("steel.json")))["parameters"].dump(),
            json["parts"]["steel"]["parameters"].dump());
}

// A part that cannot be fitted does not take the others with it.
TEST_F(Parts, OneThatFailsIsNamed) {
  write(runs_of("silver", 0.1, 0.02) +
        "[[run]]\npart = \"steel\"\ntrack = \"missing.csv\"\nphi_rad = 0\ndtau_rad = 1\n");
  const Outcome some = run("run campaign.toml -o out");
  EXPECT_EQ(some.exit_code, 4);
  EXPECT_THAT(some.err, HasSubstr("part steel: "));
  EXPECT_THAT(some.err, HasSubstr("missing.csv"));
  EXPECT_THAT(some.out, HasSubstr("part silver"));
  EXPECT_THAT(content_of(in_folder("out/parts.csv")), Not(HasSubstr("steel")));
  EXPECT_FALSE(std::filesystem::exists(in_folder("out/steel")));
}

}  // namespace
}  // namespace tribotrack::apps
