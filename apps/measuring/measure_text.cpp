#include <fmt/format.h>

#include <numbers>

#include "apps/measuring/measure_track.h"
#include "apps/text/number_text.h"

namespace tribotrack::apps {

namespace {

std::string value_text(const std::string& name, const Json& value, const Json& sd) {
  if (value.is_string()) return value.get<std::string>();
  if (!value.is_number()) return value.is_null() ? "not determined" : value.dump();
  const double number = value.get<double>();
  const bool rounded = sd.is_number() && sd.get<double>() > 0;
  const std::string text = rounded                     ? quoted(number, sd.get<double>())
                           : value.is_number_integer() ? value.dump()
                                                       : fmt::format("{:.6g}", number);
  return name.ends_with("_rad") ? fmt::format("{} ({:.2f} deg)", text, number * 180 / std::numbers::pi)
                                : text;
}

}  // namespace

std::string measurement_text(const Json& json, const std::string& within) {
  std::string text;
  for (const auto& [name, value] : json.items()) {
    const bool empty = value == "" || (value.is_structured() && value.empty());
    if (empty || name.ends_with("_sd") || name == "warnings" || name == "cov_dx_dy_mm2") continue;
    const std::string place = within.empty() ? name : within + " " + name;
    if (value.is_object()) {
      text += measurement_text(value, place);
    } else if (value.is_array() && !value.empty() && value[0].is_object()) {
      for (std::size_t k = 0; k < value.size(); ++k)
        if (value[k].value("seen", true))
          text += measurement_text(value[k], fmt::format("{} {}", place, k + 1));
    } else if (value.is_array() && !value.empty() && value[0].is_string()) {
      for (const Json& sentence : value)
        text += fmt::format("{:<36}{}\n", place, sentence.get<std::string>());
    } else {
      text += fmt::format("{:<36}{}\n", place, value_text(name, value, json.value(name + "_sd", Json())));
    }
  }
  return text;
}

}  // namespace tribotrack::apps
