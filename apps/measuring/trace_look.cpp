#include "apps/measuring/trace_look.h"

#include <fmt/format.h>

#include <numbers>
#include <vector>

#include "fit/scope_timing.h"

namespace tribotrack::apps {

namespace {

using fit::ChannelLook;
using Kind = ChannelLook::Kind;

constexpr double kSamplesNeeded = 4;  ///< to a period of the carrier, as find_scope_events demands

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

const char* word_of(Kind kind) {
  switch (kind) {
    case Kind::pulses:
      return "pulses";
    case Kind::bursts:
      return "bursts";
    case Kind::carrier:
      return "carrier";
    case Kind::quiet:
      break;
  }
  return "nothing that repeats";
}

std::string sentence_of(const ChannelLook& look) {
  switch (look.kind) {
    case Kind::pulses:
      return fmt::format("{} pulses, {:.6g} a second ({:.6g} rad/s): looks like the sensor's", look.count,
                         look.repeat_hz, 2 * std::numbers::pi * look.repeat_hz);
    case Kind::bursts:
      return fmt::format("{} bursts of {:.6g} Hz, {:.6g} a second: looks like the actuator's{}", look.count,
                         look.carrier_hz, look.repeat_hz,
                         look.samples_per_period < kSamplesNeeded
                             ? fmt::format("; {:.1f} samples to a period are too few, record faster",
                                           look.samples_per_period)
                             : "");
    case Kind::carrier:
      return fmt::format("{:.6g} Hz without a pause: an actuator that is never off?", look.carrier_hz);
    case Kind::quiet:
      break;
  }
  return "nothing that repeats";
}

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
  const std::vector<ChannelLook> looks = looks_at(trace);
  const auto samples = trace.channels.front().size();
  std::string text = fmt::format(
      "{}\n  oscilloscope trace, layout {}\n  {} samples, one in {:.6g} s ({:.6g} a second), from {:.6g} s "
      "to {:.6g} "
      "s\n",
      trace.input.path.string(), trace.layout, samples, trace.increment_s, 1 / trace.increment_s,
      trace.start_s, trace.start_s + trace.increment_s * static_cast<double>(samples - 1));
  for (std::size_t k = 0; k < looks.size(); ++k)
    text += fmt::format("  channel {} ({}): levels {:.4g} and {:.4g} V, from {:.4g} to {:.4g} V; {}\n", k + 1,
                        trace.names[k], looks[k].low, looks[k].high, looks[k].least, looks[k].most,
                        sentence_of(looks[k]));
  return text + lines_to_paste(looks);
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
                                {"looks_like", word_of(look.kind)},
                                {"count", look.count},
                                {"repeat_hz", look.repeat_hz > 0 ? Json(look.repeat_hz) : Json()},
                                {"carrier_hz", look.carrier_hz > 0 ? Json(look.carrier_hz) : Json()}});
  }
  json["scope"] = {{"sensor_channel", only(looks, Kind::pulses)},
                   {"actuator_channel", only(looks, Kind::bursts)}};
  return json;
}

}  // namespace tribotrack::apps
