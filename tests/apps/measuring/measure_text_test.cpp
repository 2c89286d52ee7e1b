#include "apps/measuring/measure_text.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

namespace tribotrack::apps {
namespace {

using testing::HasSubstr;
using testing::Not;

RunMeasurement measured() {
  RunMeasurement m;
  fit::Displacement d;
  d.vector = {-3.02329123e-3, 1.2e-3};
  d.covariance << 4e-14, 0, 0, 9e-14;
  d.cycles = 20;
  d.duration = 2;
  d.alpha = fit::Estimate{};  // from the vector
  m.displacement = d;
  fit::PlatformMotion p;
  p.amplitude = {0.28e-3, 2.9e-8};
  p.amplitude_y = {0.27e-3, 2.9e-8};
  p.angular_frequency = {62.8, 6e-5};
  p.phase_shift = {std::numbers::pi / 2, 8e-5};
  p.clockwise = true;
  p.harmonics = {{2, {4e-7, 1e-8}, {1e-9, 1e-8}}, {3, {1e-9, 1e-8}, {1e-9, 2e-8}}};
  m.platform = p;
  m.phase_source = "marker";
  m.phase_at_start = -std::numbers::pi / 2;
  return m;
}

TEST(MeasureText, RoundsWhereTheStandardDeviationSays) {
  TrackFile track;
  track.frames = 505;
  const std::string text = measurement_text(measured(), track);
  EXPECT_THAT(text, HasSubstr("(-3.02329(20), 1.20000(30)) mm in 20 cycles"));
  EXPECT_THAT(text, HasSubstr("2.763746(89) rad (158.35 deg)"));
  EXPECT_THAT(text, HasSubstr("1.62637(11) mm/s"));
  EXPECT_THAT(text, HasSubstr("turns clockwise"));
  EXPECT_THAT(text, HasSubstr("2w: 0.000400(10) mm in x"));
  EXPECT_THAT(text, HasSubstr("3w: none above 4e-05 mm"));
  EXPECT_THAT(text, HasSubstr("4.71239 rad (marker)"));
  EXPECT_THAT(text, Not(HasSubstr("gate")));
}

TEST(MeasureText, TellsTheGateAndWhatPhiCountsFrom) {
  RunMeasurement m = measured();
  fit::GateTiming gate;
  gate.phi = {1.0, 1e-3};
  gate.dtau = {0.5, 2e-3};
  gate.bracket = 0.02;
  gate.source = "lamp";
  m.gate = gate;
  m.gate_reference = "camera";
  const std::string text = measurement_text(m, {});
  EXPECT_THAT(text, HasSubstr("phi counts from the platform's phase in the picture"));
  EXPECT_THAT(text, HasSubstr("1.0000(10) rad (57.30 deg)"));
  EXPECT_THAT(text, HasSubstr("0.02 rad: no frame decides"));
  m.gate_reference = "sensor";
  EXPECT_THAT(measurement_text(m, {}), HasSubstr("phi counts from the reference sensor"));
}

TEST(MeasureText, SaysWhatIsNotSeen) {
  RunMeasurement m = measured();
  m.platform.reset();
  m.displacement->alpha.reset();
  m.displacement->covariance = 1e-4 * Eigen::Matrix2d::Identity();
  m.angular_frequency = fit::Estimate{62.8, 0};
  const std::string text = measurement_text(m, {});
  EXPECT_THAT(text, HasSubstr("not seen; w = 62.8 rad/s as given"));
  EXPECT_THAT(text, HasSubstr("none: the part stays within its uncertainty"));
}

}  // namespace
}  // namespace tribotrack::apps
