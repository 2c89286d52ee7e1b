#include "apps/measuring/measure_text.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "apps/text/number_text.h"

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

std::string measurement_text(const RunMeasurement& m, const TrackFile& track) {
  constexpr double turn = 2 * std::numbers::pi;
  const double scale_sd = track.mm_per_px ? track.mm_per_px_sd.value_or(0) / *track.mm_per_px : 0;
  std::string text =
      line("frames", fmt::format("{}, part tracked in {}", track.frames, track.table.time.size()));
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

std::string slide_measurement_text(const SlideMeasurement& m, const TrackFile& track) {
  const fit::SlideResult& s = m.slide;
  std::string text =
      line("frames", fmt::format("{}, part tracked in {}", track.frames, track.table.time.size()));
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
    text += line("  rim / slide", with_sd(s.spin_ratio) + " of the speed");
  } else {
    text +=
        line("spin", fmt::format("not seen; a rim speed of half the slide's would make mu1 {:.2g} % larger",
                                 100 * s.change_by_half_spin));
  }
  text += line("chi2", fmt::format("{:.4g} at {} degrees of freedom", s.chi2, s.dof));
  if (track.mm_per_px)
    text += line("scale", with_sd({*track.mm_per_px, track.mm_per_px_sd.value_or(0)}) + " mm per pixel");
  return text;
}

}  // namespace tribotrack::apps
