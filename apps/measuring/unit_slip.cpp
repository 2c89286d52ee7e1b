#include "apps/measuring/unit_slip.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <vector>

namespace tribotrack::apps {

namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kNear = 0.1;

struct Slip {
  double factor;  ///< from what was given to what was meant
  const char* given_as;
};

/// A length in mm.
const std::vector<Slip> kLengths = {{1e3, "in metres"}, {10, "in cm"}, {25.4, "in inches"}, {1e-3, "in um"}};

std::vector<Slip> slips_of(const std::string& quantity) {
  if (quantity == "angular_frequency_rad_s")
    return {{2 * kPi, "in Hz"},
            {2 * kPi / 60, "in revolutions per minute"},
            {kPi / 180, "in degrees per second"},
            {1 / (2 * kPi), "times 2 pi"},
            {2e3 * kPi, "in kHz"}};
  if (quantity == "phase_shift_rad") return {{kPi / 180, "in degrees"}, {2 * kPi, "in turns"}};
  std::vector<Slip> slips = kLengths;
  if (quantity.starts_with("amplitude")) {
    slips.push_back({0.5, "peak to peak"});
    slips.push_back({std::numbers::sqrt2, "as its root mean square"});
  }
  if (quantity == "diameter_mm") slips.push_back({2, "as its radius"});
  return slips;
}

std::string unit_of(const std::string& quantity) {
  return quantity.ends_with("_rad_s") ? "rad/s" : quantity.ends_with("_rad") ? "rad" : "mm";
}

bool is_near(const std::string& quantity, double meant, double measured) {
  if (quantity.ends_with("_rad"))
    return std::abs(std::remainder(meant - measured, 2 * kPi)) < kNear * kPi / 2;
  return std::abs(meant - measured) < kNear * std::abs(measured);
}

}  // namespace

std::string likely_slip(const std::string& quantity, double given, double measured) {
  for (const auto& [factor, given_as] : slips_of(quantity))
    if (is_near(quantity, given * factor, measured))
      return fmt::format("{:.4g} is {:.4g} {} {}", given, given * factor, unit_of(quantity), given_as);
  if (quantity == "angular_frequency_rad_s" && given > 0)
    for (const auto& [seconds, name] : {std::pair{1.0, "s"}, std::pair{1e-3, "ms"}})
      if (const double meant = 2 * kPi / (given * seconds); is_near(quantity, meant, measured))
        return fmt::format("{:.4g} {} is the period of {:.4g} rad/s", given, name, meant);
  return "";
}

}  // namespace tribotrack::apps
