#include "apps/measuring/condition_table.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "apps/text/number_text.h"

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

namespace {

Json value_json(const std::optional<fit::Estimate>& estimate) {
  return estimate ? finite_json(estimate->value) : Json();
}

/// Null for an exact value.
Json sd_json(const std::optional<fit::Estimate>& estimate) {
  return estimate && estimate->sd > 0 ? finite_json(estimate->sd) : Json();
}

std::string text_of(const fit::Estimate& estimate) {
  if (!(estimate.sd > 0)) return fmt::format("{:.6g}", estimate.value);
  return quoted(estimate.value, estimate.sd);
}

}  // namespace

Json conditions_json(const std::vector<ConditionRow>& rows) {
  Json json = Json::array();
  for (const ConditionRow& row : rows)
    json.push_back({{"quantity", row.quantity},
                    {"given", value_json(row.given)},
                    {"given_sd", sd_json(row.given)},
                    {"measured", value_json(row.measured)},
                    {"sd", sd_json(row.measured)},
                    {"difference_in_sd", row.difference_in_sd ? finite_json(*row.difference_in_sd) : Json()},
                    {"runs", row.runs},
                    {"p_value", finite_json(row.p_value)},
                    {"used", finite_json(row.used.value)},
                    {"used_sd", sd_json(row.used)},
                    {"from", row.from}});
  return json;
}

std::string conditions_text(const std::vector<ConditionRow>& rows) {
  if (rows.empty()) return "";
  std::string text = fmt::format("{:<26}{:>22}{:>28}{:>18}   {}\n", "condition", "given", "measured",
                                 "difference in sd", "used");
  for (const ConditionRow& row : rows)
    text += fmt::format("{:<26}{:>22}{:>28}{:>18}   {}\n", row.quantity,
                        row.given ? text_of(*row.given) : "-", row.measured ? text_of(*row.measured) : "-",
                        row.difference_in_sd ? fmt::format("{:.1f}", *row.difference_in_sd) : "-",
                        fmt::format("{}, {}", text_of(row.used), row.from));
  return text;
}

}  // namespace tribotrack::apps
