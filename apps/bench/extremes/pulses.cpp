// Extremes of the pulse: no width, full width, edges on the cycle's boundary and on each other, huge phases.
#include <cmath>
#include <numbers>

#include "apps/bench/extremes/laws.h"

namespace tribotrack::bench {

using namespace model;

namespace {

using std::numbers::pi;

Scenario with_pulse(Scenario s, double phi, double dtau) {
  s.friction.phase = phi;
  s.friction.pulse_width = dtau;
  return s;
}

/// Widths at which the edges meet, and next to them: with phi + lag = 0 they meet on the cycle's boundary.
void add_widths(ExtremeList& list, const std::string& where, double phi) {
  for (const ExtremeList::Regime* regime : {&list.slip, &list.stick}) {
    const auto name = [&](const char* width) {
      return std::string("dtau = ") + width + where + ", " + regime->name;
    };
    const Scenario none = with_pulse(regime->base, phi, 0);
    Scenario never = none, always = none;
    never.friction.reduced = never.friction.nominal;
    always.friction.nominal = always.friction.reduced;
    list.add(name("0"), none, same_as("as at constant mu1", never, 1e-11));
    list.add(name("1e-9"), with_pulse(none, phi, 1e-9), same_as("as at constant mu1", never, 1e-7));
    list.add(name("2 pi"), with_pulse(none, phi, 2 * pi), same_as("as at constant mu2", always, 1e-11));
    list.add(name("2 pi - 1e-9"), with_pulse(none, phi, 2 * pi - 1e-9),
             same_as("as at constant mu2", always, 1e-7));
  }
}

/// Opening edge just before, on and just after the start; closing edge just before, on and after the end.
void add_boundaries(ExtremeList& list) {
  for (const ExtremeList::Regime* regime : {&list.slip, &list.stick}) {
    const double width = regime->base.friction.pulse_width;
    const Scenario opens = with_pulse(regime->base, 0, width),
                   closes = with_pulse(regime->base, 2 * pi - width, width);
    list.add("closes on the cycle's end, " + regime->name, closes, scaling_law());
    Scenario split = opens;
    split.friction.phase = 0.7;
    split.friction.lag = -0.7;
    list.add("phi = -lag, " + regime->name, split, same_as("as at phi = lag = 0", opens, 1e-11));
    for (const double offset : {-1e-9, -1e-15, 1e-15, 1e-9}) {
      const double allowed = 100 * std::fabs(offset) + 1e-11;
      Scenario moved = opens;
      moved.friction.phase = offset;
      list.add("opens " + number(offset) + " rad from the start, " + regime->name, moved,
               same_as("as on the start, times 100 offsets", opens, allowed));
      moved = closes;
      moved.friction.phase += offset;
      list.add("closes " + number(offset) + " rad from the cycle's end, " + regime->name, moved,
               same_as("as on the end, times 100 offsets", closes, allowed));
    }
  }
}

}  // namespace

void add_pulse_extremes(ExtremeList& list) {
  add_widths(list, "", 0.5);
  add_widths(list, ", phi + lag = 0", 0);
  add_boundaries(list);
  const auto at_phase = [&](const std::string& name, double phi, const std::string& text, double same_phi,
                            double allowed) {
    list.add_both(
        name, [&](Scenario& s) { s.friction.phase = phi; },
        [&](const Scenario&, const Scenario& s) {
          Scenario other = s;
          other.friction.phase = same_phi;
          return same_as(text, other, allowed);
        });
  };
  list.add_both(
      "phi = 0", [](Scenario& s) { s.friction.phase = 0; },
      [](const Scenario&, const Scenario&) { return scaling_law(); });
  at_phase("phi = 2 pi", 2 * pi, "as at phi = 0", 0, 1e-11);
  at_phase("phi = -37.5", -37.5, "as at phi + 12 pi", -37.5 + 12 * pi, 1e-11);
  // Doubles near 1e6 are 1e-10 apart, but 1e6 itself is one of them: only the remainder here is rounded.
  at_phase("phi = 1e6", 1e6, "as at phi mod 2 pi", 1e6 - 159154 * (2 * pi), 1e-8);
}

}  // namespace tribotrack::bench
