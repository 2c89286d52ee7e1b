#include "model/scenario.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "model/plan.h"
#include "model/steady_orbit.h"
#include "model/trajectory.h"

namespace tribotrack::model {
namespace {

std::string refusal(const Scenario& s) {
  try {
    s.validate();
  } catch (const InvalidParameter& error) {
    return error.what();
  }
  return "";
}

/// Whoever is handed a bad scenario refuses it by the parameter's name, next to the range's ends too.
TEST(Scenario, EveryEntranceRefuses) {
  const double inf = std::numeric_limits<double>::infinity(), next = std::nextafter(2 * std::numbers::pi, 7);
  const std::vector<std::pair<Parameter, double>> bad = {{Parameter::mu1, -1e-300},
                                                         {Parameter::mu2, -inf},
                                                         {Parameter::dtau, next},
                                                         {Parameter::dtau, -1e-300},
                                                         {Parameter::gravity, 0},
                                                         {Parameter::gravity, -9.81},
                                                         {Parameter::angular_frequency, 0},
                                                         {Parameter::angular_frequency, -62.8},
                                                         {Parameter::amplitude, -1e-300},
                                                         {Parameter::amplitude_y, -inf},
                                                         {Parameter::phi, inf},
                                                         {Parameter::lag, -inf},
                                                         {Parameter::phase_shift, inf},
                                                         {Parameter::tilt_x, inf},
                                                         {Parameter::tilt_y, std::nan("")},
                                                         {Parameter::velocity_x, inf},
                                                         {Parameter::start_phase, std::nan("")}};
  for (const auto& [wrong, value] : bad) {
    Scenario s;
    s.set(wrong, value);
    // Named anew: clang before 16 takes no structured binding into a lambda.
    const auto refuses = [parameter = wrong](auto&& entrance) {
      try {
        entrance();
        ADD_FAILURE() << to_string(parameter) << " was accepted";
      } catch (const InvalidParameter& error) {
        EXPECT_THAT(error.what(), testing::HasSubstr(to_string(parameter)));
      }
    };
    refuses([&] { integrate(s); });
    refuses([&] { steady_orbit(s); });
    refuses([&] { plan(s); });
  }
  for (const double cycles : {-1.0, inf, std::nan("")}) {
    Scenario s;
    s.cycles = cycles;
    EXPECT_THAT(refusal(s), testing::HasSubstr("cycles"));
    s = Scenario{};
    s.duration = cycles;
    EXPECT_THAT(refusal(s), testing::HasSubstr("duration"));
  }
}

TEST(Scenario, LegalExtremes) {
  for (const double dtau : {0.0, 2 * std::numbers::pi}) {
    Scenario s;
    s.friction = {0, 0, 1e6, dtau, -1e6};
    s.drive.amplitude = s.drive.amplitude_y = 0;
    EXPECT_EQ(refusal(s), "");
    EXPECT_EQ(integrate(s).end().position.norm(), 0);
  }
}

}  // namespace
}  // namespace tribotrack::model
