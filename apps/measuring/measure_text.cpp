#include "apps/measuring/measure_text.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "apps/text/number_text.h"
#include "fit/scope_timing.h"

namespace tribotrack::apps {

namespace {

constexpr double kMillimetre = 1e-3;
constexpr double kDegree = std::numbers::pi / 180;

std::string with_sd(const fit::Estimate& estimate, double unit = 1) {
  const double value = estimate.value / unit, sd = estimate.sd / unit;
  if (!(sd > 0)) return fmt::format("{:.8g}", value);
  return quoted(value, sd);
}

std::string line(const char* name, const std::string& text) {
  return fmt::format("{:<16}{}\n", name, text);
}

std::string frames_text(const Track& track) {
  std::string text = fmt::format("{}, part tracked in {}", track.frames, track.table.time.size());
  if (track.repeats > 0) text += fmt::format("; {} repeat the picture before", track.repeats);
  if (track.missing > 0)
    text += fmt::format("; {} missing in the recording, by its timestamps", track.missing);
  return line("frames", text);
}

std::string displacement_text(const fit::Displacement& d) {
  const auto sd = [&](int i) { return std::sqrt(d.covariance(i, i)); };
  std::string text = line("displacement",
                          fmt::format("({}, {}) mm in {} cycles", with_sd({d.vector.x(), sd(0)}, kMillimetre),
                                      with_sd({d.vector.y(), sd(1)}, kMillimetre), d.cycles));
  text +=
      line("alpha", d.alpha ? fmt::format("{} rad ({:.2f} deg)", with_sd(*d.alpha), d.alpha->value / kDegree)
                            : std::string("none: the part stays within its uncertainty"));
  return text + line("v", with_sd(d.mean_velocity, kMillimetre) + " mm/s");
}

std::string harmonics_text(const fit::PlatformMotion& p) {
  std::string text;
  for (const fit::Harmonic& h : p.harmonics) {
    if (!text.empty()) text += "; ";
    text += h.seen() ? fmt::format("{}w: {} mm in x, {} mm in y", h.order, with_sd(h.amplitude, kMillimetre),
                                   with_sd(h.amplitude_y, kMillimetre))
                     : fmt::format("{}w: none above {:.2g} mm", h.order,
                                   2 * std::max(h.amplitude.sd, h.amplitude_y.sd) / kMillimetre);
  }
  return text;
}

std::string platform_text(const fit::PlatformMotion& p, const std::string& seen_by) {
  std::string text = line("platform", fmt::format("seen by its {}, turns {}", seen_by,
                                                  p.clockwise ? "clockwise" : "counter-clockwise"));
  text += line("  A", with_sd(p.amplitude, kMillimetre) + " mm");
  text += line("  A_y", with_sd(p.amplitude_y, kMillimetre) + " mm");
  text += line("  epsilon", with_sd(p.phase_shift) + " rad");
  text += line("  w", fmt::format("{} rad/s ({:.6g} Hz)", with_sd(p.angular_frequency),
                                  p.angular_frequency.value / (2 * std::numbers::pi)));
  if (p.frequency_drift)
    text += line("  drift of w", fmt::format("{} rad/s^2{}", with_sd(*p.frequency_drift),
                                             p.frequency_drifts() ? "" : ": none seen"));
  text += line("  phase at 0", with_sd(p.phase_at_zero) + " rad");
  if (!p.harmonics.empty()) text += line("  harmonics", harmonics_text(p));
  return text + line("  residual", fmt::format("{:.2g} mm rms", p.residual_rms / kMillimetre));
}

std::string gate_text(const fit::GateTiming& gate, const std::string& counts_from) {
  std::string text = line(
      "gate", fmt::format("seen by {} in {} cycles; phi counts from the {}", gate.source, gate.cycles,
                          counts_from == "camera" ? "platform's phase in the picture" : "reference sensor"));
  text += line("  phi", fmt::format("{} rad ({:.2f} deg)", with_sd(gate.phi), gate.phi.value / kDegree));
  text += line("  dtau", fmt::format("{} rad ({:.2f} deg)", with_sd(gate.dtau), gate.dtau.value / kDegree));
  if (gate.bracket > 0)
    text +=
        line("  bracket", fmt::format("{:.2g} rad: no frame decides where in it an edge lies", gate.bracket));
  if (gate.jitter > 0)
    text += line("  jitter", fmt::format("{:.2g} rad rms from cycle to cycle", gate.jitter));
  return text;
}

}  // namespace

std::string measurement_text(const RunMeasurement& m, const Track& track) {
  constexpr double turn = 2 * std::numbers::pi;
  const double scale_sd = track.mm_per_px ? track.mm_per_px_sd.value_or(0) / *track.mm_per_px : 0;
  std::string text = frames_text(track);
  if (m.displacement) text += displacement_text(fit::with_scale_sd(*m.displacement, scale_sd));
  if (m.platform)
    text += platform_text(fit::with_scale_sd(*m.platform, scale_sd), m.phase_source);
  else if (m.angular_frequency)
    text += line("platform", fmt::format("not seen; w = {} rad/s as given", with_sd(*m.angular_frequency)));
  text += line("phase at start",
               fmt::format("{:.6g} rad ({})", m.phase_at_start - turn * std::floor(m.phase_at_start / turn),
                           m.phase_source));
  if (m.gate) text += gate_text(*m.gate, m.gate_reference);
  if (track.mm_per_px)
    text += line("scale", with_sd({*track.mm_per_px, track.mm_per_px_sd.value_or(0)}) + " mm per pixel");
  return text;
}

std::string motion_text(const TrackMotion& motion) {
  return line("motion", fmt::format("{}: {}", fit::to_string(motion.shown.kind), motion.sentence));
}

std::string slide_measurement_text(const SlideMeasurement& m, const Track& track) {
  const fit::SlideResult& s = m.slide;
  std::string text = frames_text(track);
  text +=
      line("free slide", fmt::format("frames {} to {}, {} points", s.first_frame, s.last_frame, s.points));
  text += line("speed", fmt::format("{:.4g} mm/s at its first point", 1e3 * s.speed));
  text += line("deceleration", with_sd(m.deceleration, kMillimetre) + " mm/s^2");
  if (m.deceleration_slow_sd > 0)
    text += line("  slow sd", fmt::format("{:.2g} mm/s^2 of it: what the track's slow errors can make",
                                          1e3 * m.deceleration_slow_sd));
  text += line("mu1", fmt::format("{} with g = {} m/s^2",
                                  with_sd({s.mu1.value, m.deceleration.sd / m.gravity}), m.gravity));
  text += line("stop", fmt::format("{:.5g} s{}", s.stop_time, m.stop_seen ? "" : ", after the track ends"));
  if (s.spin_seen) {
    text += line("spin", with_sd(s.spin) + " rad/s at its first point");
    text += line("  edge / slide", with_sd(s.spin_ratio) + " of the speed");
  } else {
    text +=
        line("spin",
             fmt::format("not seen; an edge speed of half the sliding speed would make mu1 {:.2g} % larger",
                         100 * s.change_by_half_spin));
  }
  text += line("chi2", fmt::format("{:.4g} at {} degrees of freedom", s.chi2, s.dof));
  if (track.mm_per_px)
    text += line("scale", with_sd({*track.mm_per_px, track.mm_per_px_sd.value_or(0)}) + " mm per pixel");
  return text;
}

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
