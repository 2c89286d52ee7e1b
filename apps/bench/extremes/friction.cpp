// Extremes of mu1, mu2 and of their place against the drive a = A w^2.
#include <cmath>
#include <numbers>

#include "apps/bench/extremes/laws.h"

namespace tribotrack::bench {

using namespace model;

namespace {

Scenario with_mu(Scenario s, double mu1, double mu2) {
  s.friction.nominal = mu1;
  s.friction.reduced = mu2;
  return s;
}

Scenario without_pulses(Scenario s) {
  s.friction.pulse_width = 0;
  return s;
}

}  // namespace

void add_friction_extremes(ExtremeList& list) {
  const auto scaling = [](const Scenario&, const Scenario&) { return scaling_law(); };
  const auto as_constant = [](const Scenario&, const Scenario& s) {
    return same_as("as without pulses", without_pulses(s), 1e-11);
  };
  list.add_both(
      "mu2 = 0", [](Scenario& s) { s.friction.reduced = 0; }, scaling);
  list.add_both(
      "mu1 = mu2", [](Scenario& s) { s.friction.reduced = s.friction.nominal; }, as_constant);
  list.add_both(
      "mu1/mu2 = 1e6", [](Scenario& s) { s.friction.reduced = 1e-6 * s.friction.nominal; }, scaling);

  const Scenario& base = list.slip.base;
  const double threshold = drive_strength(base) / base.drive.gravity;
  list.add("mu1 = 0, mu2 > 0", with_mu(base, 0, 0.0125), scaling_law());
  list.add("mu1 = 0, mu2 sticks", with_mu(base, 0, 2 * threshold), scaling_law());
  list.add("mu1 = mu2 = 0", with_mu(base, 0, 0),
           ends_at("drifts by -A w t in y",
                   {0, -base.drive.amplitude * base.drive.angular_frequency * base.end_time()}));
  list.add("a/(mu1 g) = 1e-3, held", with_mu(base, 1e3 * threshold, 125 * threshold), never_moves());
  list.add("a/(mu1 g) = 1e-3, sticks", with_mu(base, 1e3 * threshold, 0.0125), scaling_law());
  list.add("a/(mu1 g) = 1e4", with_mu(base, 1e-4 * threshold, 1.25e-5 * threshold), scaling_law());
  list.add("mu1 g = 100 a", with_mu(base, 100 * threshold, 0.0125), scaling_law());
}

void add_threshold_extremes(ExtremeList& list) {
  const Scenario& base = list.slip.base;
  const double a = drive_strength(base), g = base.drive.gravity, threshold = a / g;
  const auto pulsed = [&](double mu1) { return with_mu(base, mu1, threshold / 8); };
  const auto constant = [&](double mu1) { return without_pulses(with_mu(base, mu1, mu1)); };

  list.add("a = mu1 g", pulsed(threshold), scaling_law());
  list.add("a = mu1 g, no pulses", constant(threshold), never_moves());
  list.add("mu1 g = 2 a", pulsed(2 * threshold), scaling_law());
  for (const double offset : {1e-3, 1e-6, 1e-9, 1e-12})
    for (const double side : {1.0, -1.0}) {
      const std::string sign = side > 0 ? "+ " : "- ";
      const double mu = threshold / (1 + side * offset);
      // The path's own dependence on mu1 is of the order of its relative change.
      list.add("a/(mu1 g) = 1 " + sign + number(offset), pulsed(mu),
               same_as("as at 1, times 100 offsets", pulsed(threshold), 100 * offset + 1e-11));
      list.add("a/(mu1 g) = 1 " + sign + number(offset) + ", no pulses", constant(mu),
               side > 0 ? creeps_at_most(a - mu * g) : never_moves());
      list.add("mu1 g = 2 a (1 " + sign + number(offset) + ")", pulsed(2 * threshold * (1 + side * offset)),
               same_as("as at 2 a, times 10 offsets", pulsed(2 * threshold), 10 * offset + 1e-11));
    }
}

}  // namespace tribotrack::bench
