// Rendered recordings of one experiment by a camera that stands straight and one that is turned: the fitted
// lag with a lamp in the picture, and with phi only as commanded.
#include <gmock/gmock.h>

#include <numbers>
#include <regex>
#include <string>

#include "apps/files/run_folder.h"
#include "apps/program.h"

namespace tribotrack::apps {
namespace {

using ::testing::HasSubstr;

class TurnedCameraCampaign : public ProgramTest {
 protected:
  void render(const std::string& folder, double turn) {
    put(in_folder("scene.toml"), R"(
[platform]
amplitude_mm = 0.28
angular_frequency_rad_s = 62.8
[friction]
mu1 = 0.1
mu1_over_mu2 = 8
lag_rad = 0.2
[run]
cycles = 8
[video]
width = 200
height = 200
frame_rate_hz = 250
exposure_s = 4e-3
[camera]
mm_per_px = 0.1
read_noise = 2
xi_axis_rad = )" + std::to_string(turn) +
                                     R"(
[disc]
diameter_mm = 3.6
[surface]
level = 70
texture_rms = 0
[marker]
position_px = [24, 24]
radius_px = 12
[lamp]
position_px = [176, 24]
radius_px = 7
[[shot]]
name = "a"
phi_rad = 0.5
dtau_rad = "pi/3"
[[shot]]
name = "b"
phi_rad = 2.5
dtau_rad = "2pi/3"
seed = 2
)");
    ASSERT_EQ(run("synth scene.toml -o " + folder + " -q").exit_code, 0);
  }
  /// The lag fitted to the folder's recordings, mu1 and mu2 as known.
  Json fit_of(const std::string& folder, const std::string& camera) {
    put(in_folder("c.toml"),
        "[platform]\nphase_shift_rad = \"pi/2\"\n[camera]\nmm_per_px = 0.1\n"
        "marker_px = [24, 24, 12]\n" +
            camera +
            "[fit]\nparameters = [\"phase_lag_rad\"]\ncycles = 8\n[fit.fixed]\nmu1 = "
            "0.1\nmu2 = 0.0125\n"
            "[[run]]\nvideo = \"" +
            folder + "/a.cine\"\nphi_rad = 0.5\ndtau_rad = \"pi/3\"\n[[run]]\nvideo = \"" + folder +
            "/b.cine\"\nphi_rad = 2.5\ndtau_rad = \"2pi/3\"\n");
    const std::string out = folder + std::to_string(++count_);
    const Outcome outcome = run("run c.toml -q -o " + out);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return read_json(in_folder(out) / "fit.json");
  }
  static double lag(const Json& fit) { return fit["parameters"]["phase_lag_rad"]["estimate"]; }
  static double sd(const Json& fit) { return fit["parameters"]["phase_lag_rad"]["sd"]; }
  int count_ = 0;
};

TEST_F(TurnedCameraCampaign, DISABLED_ALampTakesItOutACommandedPhiTakesItUp) {
  const double turn = 0.7;
  render("straight", 0);
  render("turned", turn);
  const std::string lamp = "gate_px = [176, 24, 6]\n";
  const Json straight = fit_of("straight", lamp), turned = fit_of("turned", lamp);
  EXPECT_NEAR(lag(straight), 0.2, 4 * sd(straight));
  EXPECT_NEAR(lag(turned), lag(straight), 4 * std::hypot(sd(straight), sd(turned)));
  EXPECT_LT(sd(turned), 0.02);
  EXPECT_THAT(turned["phase_reference"].get<std::string>(), HasSubstr("does not depend"));
  for (const Json& entry : turned["runs"]) EXPECT_EQ(entry["phi_from"], "lamp");

  const Json commanded = fit_of("turned", "");
  EXPECT_NEAR(lag(commanded), 0.2 - turn, 4 * sd(commanded));
  EXPECT_THAT(commanded["phase_reference"].get<std::string>(), HasSubstr("biases the phase lag"));
  const Json told = fit_of("turned", "xi_axis_rad = " + std::to_string(turn) + "\n");
  EXPECT_NEAR(lag(told), 0.2, 4 * sd(told));

  const Json seen = read_json(in_folder("turned2") / "measurements" / "a.json");
  EXPECT_NEAR(seen["phi_rad"], 0.5 - turn + 2 * std::numbers::pi, 3e-3);
  EXPECT_NEAR(seen["dtau_rad"], std::numbers::pi / 3, 3e-3);
  EXPECT_GT(seen["phi_rad_sd"], 0);
}

}  // namespace
}  // namespace tribotrack::apps
