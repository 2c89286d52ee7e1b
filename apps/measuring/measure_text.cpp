#include "apps/measuring/measure_text.h"

#include <fmt/format.h>

#include <numbers>
#include <vector>

#include "apps/text/number_text.h"
#include "fit/scope_timing.h"

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

namespace {

using fit::ChannelLook;
using Kind = ChannelLook::Kind;

std::vector<ChannelLook> looks_at(const ScopeFile& trace) {
  std::vector<ChannelLook> looks;
  for (const auto& channel : trace.channels)
    looks.push_back(fit::look_at_channel(channel, trace.increment_s));
  return looks;
}

/// 1 = the first; 0: none, or more than one.
int only(const std::vector<ChannelLook>& looks, Kind kind) {
  int found = 0;
  for (std::size_t k = 0; k < looks.size(); ++k)
    if (looks[k].kind == kind) {
      if (found != 0) return 0;
      found = static_cast<int>(k) + 1;
    }
  return found;
}

/// In the order of Kind.
constexpr const char* kWords[] = {"nothing that repeats", "pulses", "bursts", "carrier"};

std::string lines_to_paste(const std::vector<ChannelLook>& looks) {
  const int sensor = only(looks, Kind::pulses), actuator = only(looks, Kind::bursts);
  if (sensor == 0 && actuator == 0)
    return "no channel looks like the sensor's pulses or the actuator's bursts: name them yourself, [scope] "
           "sensor_channel, actuator_channel\n";
  std::string text = fmt::format("[scope]\nsensor_channel = {}\nactuator_channel = {}\n", sensor, actuator);
  if (actuator > 0)
    text += fmt::format("carrier_hz = {:.5g}\n", looks[static_cast<std::size_t>(actuator) - 1].carrier_hz);
  return text;
}

}  // namespace

std::string trace_text(const ScopeFile& trace) {
  return measurement_text(trace_json(trace)) + lines_to_paste(looks_at(trace));
}

Json trace_json(const ScopeFile& trace) {
  const std::vector<ChannelLook> looks = looks_at(trace);
  Json json = {{"path", trace.input.path.string()},
               {"format", "oscilloscope trace"},
               {"layout", trace.layout},
               {"samples", trace.channels.front().size()},
               {"start_s", trace.start_s},
               {"increment_s", trace.increment_s},
               {"channels", Json::array()}};
  for (std::size_t k = 0; k < looks.size(); ++k) {
    const ChannelLook& look = looks[k];
    json["channels"].push_back({{"name", trace.names[k]},
                                {"low_v", look.low},
                                {"high_v", look.high},
                                {"min_v", look.least},
                                {"max_v", look.most},
                                {"looks_like", kWords[static_cast<int>(look.kind)]},
                                {"count", look.count},
                                {"repeat_hz", look.repeat_hz > 0 ? Json(look.repeat_hz) : Json()},
                                {"carrier_hz", look.carrier_hz > 0 ? Json(look.carrier_hz) : Json()}});
  }
  json["scope"] = {{"sensor_channel", only(looks, Kind::pulses)},
                   {"actuator_channel", only(looks, Kind::bursts)}};
  return json;
}

}  // namespace tribotrack::apps
