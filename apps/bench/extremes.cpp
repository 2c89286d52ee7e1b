// Laws of the extreme cases; the extremes of friction, of its place against the drive a = A w^2, and of the
// pulse: no width, full width, edges on the cycle's boundary and on each other, huge phases; and those of the
// drive and of the start.
#include "apps/bench/model.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "model/steady_orbit.h"
#include "model/trajectory.h"

namespace tribotrack::bench {

using namespace model;

namespace {

using Eigen::Vector2d;
using std::numbers::pi;

double relative(const Vector2d& difference, double size) {
  const double gap = difference.norm();
  return gap == 0 ? 0 : gap / std::max(size, std::numeric_limits<double>::min());
}

/// The longer of a path and A.
double size_of(const Scenario& s, const Vector2d& end) {
  return std::max({end.norm(), s.drive.amplitude, s.drive.amplitude_y});
}

/// What exceeds a bound, relative to A.
double excess(const Scenario& s, double path, double bound) {
  return std::max(0.0, path - bound) / std::max(s.drive.amplitude, s.drive.amplitude_y);
}

/// End point at the default tolerance.
Vector2d end_of(const Scenario& scenario) {
  return integrate(scenario).end().position;
}

/// For names.
std::string number(double value) {
  return fmt::format("{:g}", value);
}

/// a = A w^2, m/s^2.
double drive_strength(const Scenario& s) {
  return s.drive.amplitude * s.drive.angular_frequency * s.drive.angular_frequency;
}

/// (A, w) -> (A/9, 3w) leaves x/A as a function of wt: a = A w^2, and with it every ratio to mu g, stays.
ExtremeLaw scaling_law() {
  return {"(A/9, 3w): x/A unchanged", 1e-11, [](const Scenario& s, const Vector2d& end) {
            Scenario twin = s;
            twin.drive.amplitude /= 9;
            twin.drive.amplitude_y /= 9;
            twin.drive.angular_frequency *= 3;
            twin.initial_velocity /= 3;
            twin.duration /= 3;
            return relative(9 * end_of(twin) - end, size_of(s, end));
          }};
}

/// The end point of a neighbouring scenario agrees, relative to the path or A, whichever is longer.
ExtremeLaw same_as(const std::string& text, const Scenario& other, double allowed) {
  return {text, allowed, [other](const Scenario& s, const Vector2d& end) {
            return relative(end - end_of(other), size_of(s, end));
          }};
}

ExtremeLaw ends_at(const std::string& text, const Vector2d& place, double allowed = 1e-11) {
  return {text, allowed,
          [place](const Scenario&, const Vector2d& end) { return relative(end - place, place.norm()); }};
}

ExtremeLaw never_moves() {
  return {"never moves", 0, [](const Scenario&, const Vector2d& end) { return end.norm(); }};
}

/// From rest the speed grows at most at |drive| - mu g: path <= surplus T^2/2. The violation is what exceeds
/// it, relative to A.
ExtremeLaw creeps_at_most(double surplus) {
  return {"path at most (|drive| - mu1 g) T^2/2, exceeded by (of A)", 1e-11,
          [surplus](const Scenario& s, const Vector2d& end) {
            const double time = s.end_time();
            return excess(s, end.norm(), std::max(0.0, surplus) * time * time / 2);
          }};
}

/// Two starts never separate: |x - x'| <= |u0 - u0'| T. The violation is what exceeds it, relative to A.
ExtremeLaw never_separates_from(const Scenario& other) {
  return {"|x - x'| <= |u0 - u0'| T, exceeded by (of A)", 1e-11,
          [other](const Scenario& s, const Vector2d& end) {
            const double apart = (s.initial_velocity - other.initial_velocity).norm();
            return excess(s, (end - end_of(other)).norm(), apart * s.end_time());
          }};
}

/// Once periodic, every cycle adds the drift of the periodic orbit.
ExtremeLaw last_half_adds_drifts() {
  return {"last half adds (cycles/2) drifts of the periodic orbit", 1e-11,
          [](const Scenario& scenario, const Vector2d& end) {
            Scenario half = scenario;
            half.cycles /= 2;
            const auto orbit = steady_orbit(scenario);
            if (!orbit) return std::numeric_limits<double>::infinity();
            return relative(end - end_of(half) - half.cycles * orbit->drift, end.norm());
          }};
}

/// Drive along a line through the origin: the part stays on it.
ExtremeLaw stays_on_line(double slope) {
  return {slope > 0 ? "stays on the line y = x" : "stays on the line y = -x", 1e-11,
          [slope](const Scenario& s, const Vector2d& end) {
            return relative(Vector2d(end.y() - slope * end.x(), 0), size_of(s, end));
          }};
}

template <class Change>
Scenario with(Scenario s, Change change) {
  change(s);
  return s;
}

struct ExtremeList {
  bool quick;
  std::vector<ExtremeCase> cases = {};
  void add(std::string name, const Scenario& scenario, ExtremeLaw law = scaling_law()) {
    cases.push_back({std::move(name), scenario, std::move(law)});
  }
};

/// Other amplitudes and frequencies; friction that follows the drive, or stays as it is.
Scenario rescaled(const Scenario& base, double amplitude, double angular_frequency, bool friction_follows) {
  return with(base, [&](Scenario& s) {
    s.drive.amplitude = s.drive.amplitude_y = amplitude;
    s.drive.angular_frequency = angular_frequency;
    const double factor = friction_follows ? drive_strength(s) / drive_strength(base) : 1;
    s.friction.nominal *= factor;
    s.friction.reduced *= factor;
  });
}

/// What exists for a part that slips and for one that sticks.
void add_of_regime(ExtremeList& list, const Scenario& base, const std::string& regime) {
  const auto add = [&](const std::string& name, const Scenario& s, const ExtremeLaw& law = scaling_law()) {
    list.add(name + ", " + regime, s, law);
  };
  const auto with_phase = [&](double phi) {
    return with(base, [=](Scenario& s) { s.friction.phase = phi; });
  };
  const auto with_epsilon = [&](double e) {
    return with(base, [=](Scenario& s) { s.drive.phase_shift = e; });
  };
  const auto pulsed = [&](double phi, double dtau) {
    return with(with_phase(phi), [=](Scenario& s) { s.friction.pulse_width = dtau; });
  };

  add("mu2 = 0", with(base, [](Scenario& s) { s.friction.reduced = 0; }));
  add("mu1 = mu2", with(base, [](Scenario& s) { s.friction.reduced = s.friction.nominal; }),
      same_as("as without pulses", pulsed(base.friction.phase, 0), 1e-11));
  add("mu1/mu2 = 1e6", with(base, [](Scenario& s) { s.friction.reduced = 1e-6 * s.friction.nominal; }));

  // Widths at which the edges meet, and next to them: with phi + lag = 0 they meet on the cycle's boundary.
  for (const auto& [where, phi] : {std::pair("", 0.5), {", phi + lag = 0", 0.0}}) {
    const auto width = [&, at = where](const char* text) { return std::string("dtau = ") + text + at; };
    const Scenario never = with(pulsed(phi, 0), [](Scenario&s) { s.friction.reduced = s.friction.nominal; }),
                   always = with(pulsed(phi, 0), [](Scenario&s) { s.friction.nominal = s.friction.reduced; });
    add(width("0"), pulsed(phi, 0), same_as("as at constant mu1", never, 1e-11));
    add(width("1e-9"), pulsed(phi, 1e-9), same_as("as at constant mu1", never, 1e-7));
    add(width("2 pi"), pulsed(phi, 2 * pi), same_as("as at constant mu2", always, 1e-11));
    add(width("2 pi - 1e-9"), pulsed(phi, 2 * pi - 1e-9), same_as("as at constant mu2", always, 1e-7));
  }

  // Opening edge just before, on and just after the start; closing edge just before, on and after the end.
  const double closes = 2 * pi - base.friction.pulse_width;
  add("phi = 0", with_phase(0));
  add("closes on the cycle's end", with_phase(closes));
  add("phi = -lag", with(with_phase(0.7), [](Scenario& s) { s.friction.lag = -0.7; }),
      same_as("as at phi = lag = 0", with_phase(0), 1e-11));
  for (const double offset : {-1e-9, -1e-15, 1e-15, 1e-9}) {
    const double allowed = 100 * std::fabs(offset) + 1e-11;
    add("opens " + number(offset) + " rad from the start", with_phase(offset),
        same_as("as on the start, times 100 offsets", with_phase(0), allowed));
    add("closes " + number(offset) + " rad from the cycle's end", with_phase(closes + offset),
        same_as("as on the end, times 100 offsets", with_phase(closes), allowed));
  }
  add("phi = 2 pi", with_phase(2 * pi), same_as("as at phi = 0", with_phase(0), 1e-11));
  add("phi = -37.5", with_phase(-37.5), same_as("as at phi + 12 pi", with_phase(-37.5 + 12 * pi), 1e-11));
  // Doubles near 1e6 are 1e-10 apart, but 1e6 itself is one of them: only the remainder here is rounded.
  add("phi = 1e6", with_phase(1e6), same_as("as at phi mod 2 pi", with_phase(1e6 - 159154 * (2 * pi)), 1e-8));

  add("epsilon = 0", with_epsilon(0), stays_on_line(1));
  add("epsilon = pi", with_epsilon(pi), stays_on_line(-1));
  add("epsilon = 1e-8", with_epsilon(1e-8), same_as("as at 0", with_epsilon(0), 1e-6));
  for (const double offset : {1e-12, -1e-12})
    add(std::string("epsilon = pi/2 ") + (offset > 0 ? "+" : "-") + " 1e-12", with_epsilon(pi / 2 + offset),
        same_as("as at pi/2", base, 1e-10));
  // Counter-clockwise is the mirror image of cos(wt + pi/2).
  const Vector2d end = end_of(base);
  add("epsilon = -pi/2", with_epsilon(-pi / 2), ends_at("mirror image of pi/2", {end.x(), -end.y()}));

  const double a = base.drive.amplitude, w = base.drive.angular_frequency;
  add("w = 1e-3 rad/s", rescaled(base, a, 1e-3, true));
  add("w = 1e5 rad/s", rescaled(base, a, 1e5, true));
  add("A = 1 nm", rescaled(base, 1e-9, w, true));
  add("A = 1 m", rescaled(base, 1, w, true));
  for (const double offset : {1e-6, 1e-9})
    for (const double side : {-1.0, 1.0})
      add("shaken, tilt " + number(offset) + (side < 0 ? " below sliding" : " above sliding"),
          with(base,
               [&](Scenario& s) { s.drive.tilt_y = std::asin(s.friction.nominal * (1 + side * offset)); }));

  // A drive along a line, the velocity against it and slightly beside it: u misses 0 by about `miss`.
  const auto against = [&](double beside) {
    return with(base, [&](Scenario& s) {
      s.drive.phase_shift = 0;
      s.initial_velocity = a * w * Vector2d(Vector2d(-0.3 - beside, -0.3 + beside) / std::sqrt(2.0));
    });
  };
  const auto thrown = [&](double ux, double uy) {
    return with(base, [=](Scenario& s) { s.initial_velocity = {ux, uy}; });
  };
  for (const double miss : {1e-3, -1e-3, 1e-8, -1e-8, 1e-14, -1e-14})
    add("u misses 0 by " + number(miss) + " of A w", against(miss), never_separates_from(against(0)));
  add("initial speed 1e-300 m/s", thrown(1e-300, 0), same_as("as from rest", base, 1e-11));
  for (const double speed : {1e-17, 1e-8})
    add("initial speed " + number(speed) + " m/s", thrown(speed, speed / 3), never_separates_from(base));
  add("initial speed 1e3 m/s", thrown(1e3, 0));
  // How rounding grows with the number of cycles is in the violations of these.
  for (const double cycles : list.quick ? std::vector<double>{100} : std::vector<double>{1e2, 1e4, 1e6})
    add(number(cycles) + " cycles", with(base, [&](Scenario& s) { s.cycles = cycles; }),
        last_half_adds_drifts());
}

/// mu1 against the drive a = A w^2, and next to the values at which the part begins to stick and to stay.
void add_thresholds(ExtremeList& list, const Scenario& base) {
  const double a = drive_strength(base), g = base.drive.gravity, threshold = a / g;
  const auto friction = [&](double mu1, double mu2) {
    return with(base, [=](Scenario& s) {
      s.friction.nominal = mu1;
      s.friction.reduced = mu2;
    });
  };
  const auto pulsed = [&](double mu1) { return friction(mu1, threshold / 8); };
  const auto constant = [&](double mu1) {
    return with(friction(mu1, mu1), [](Scenario& s) { s.friction.pulse_width = 0; });
  };
  list.add("mu1 = 0, mu2 > 0", friction(0, 0.0125));
  list.add("mu1 = 0, mu2 sticks", friction(0, 2 * threshold));
  list.add("mu1 = mu2 = 0", friction(0, 0),
           ends_at("drifts by -A w t in y",
                   {0, -base.drive.amplitude * base.drive.angular_frequency * base.end_time()}));
  list.add("a/(mu1 g) = 1e-3, held", friction(1e3 * threshold, 125 * threshold), never_moves());
  list.add("a/(mu1 g) = 1e-3, sticks", friction(1e3 * threshold, 0.0125));
  list.add("a/(mu1 g) = 1e4", friction(1e-4 * threshold, 1.25e-5 * threshold));
  list.add("mu1 g = 100 a", friction(100 * threshold, 0.0125));
  list.add("a = mu1 g", pulsed(threshold));
  list.add("a = mu1 g, no pulses", constant(threshold), never_moves());
  list.add("mu1 g = 2 a", pulsed(2 * threshold));
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

/// Scales that friction does not follow, tilts at which a resting part begins to slide, a free slide.
void add_drives(ExtremeList& list, const Scenario& slips, const Scenario& sticks) {
  const double a = slips.drive.amplitude, w = slips.drive.angular_frequency, g = slips.drive.gravity;
  list.add("w = 1e-3 rad/s, mu1 = 0.1", rescaled(slips, a, 1e-3, false), never_moves());
  list.add("w = 1e5 rad/s, mu1 = 0.1", rescaled(slips, a, 1e5, false));
  list.add("A = 1 nm, mu1 = 0.1", rescaled(slips, 1e-9, w, false), never_moves());
  list.add("A = 1 m, mu1 = 0.1", rescaled(slips, 1, w, false));
  const Scenario constant = with(sticks, [](Scenario& s) { s.friction.pulse_width = 0; });
  // The drive grows smoothly through friction once a cycle: by ever less.
  for (const double tilt : {0.03, 0.0078, 0.00744})
    list.add("takes off smoothly, tilt " + number(tilt), with(constant, [&](Scenario& s) {
               s.friction.nominal = 0.12;
               s.drive.tilt_x = tilt;
             }));
  const Scenario resting = with(slips, [](Scenario& s) {
    s.drive.amplitude = s.drive.amplitude_y = 0;
    s.friction.pulse_width = 0;
    s.duration = 2;
  });
  for (const double offset : {1e-6, 1e-9})
    for (const double side : {-1.0, 1.0}) {
      const std::string where = number(offset) + (side < 0 ? " below sliding" : " above sliding");
      Scenario s = resting;
      s.drive.tilt_x = std::asin(s.friction.nominal * (1 + side * offset));
      const double left = g * std::sin(s.drive.tilt_x) - s.friction.nominal * g;
      // The difference of two nearly equal numbers: good to epsilon / offset.
      list.add("A = 0, tilt " + where, s,
               side < 0 ? never_moves()
                        : ends_at("slides (g sin tilt - mu g) t^2/2",
                                  {0.5 * left * s.duration * s.duration, 0}, 1e-15 / offset));
      // On a shaken platform: where drive and tilt add up to friction.
      s = constant;
      const double strength = drive_strength(s), m = s.friction.nominal * g;
      s.drive.tilt_x = std::asin((m * (1 + side * offset) - strength) / g);
      list.add("drive + tilt " + where, s,
               side < 0 ? never_moves() : creeps_at_most(strength + g * std::sin(s.drive.tilt_x) - m));
    }
  const double path = 0.25 / (2 * resting.friction.nominal * g);  // u^2 / (2 mu g) along u
  list.add("A = 0, free slide to its stop",
           with(resting,
                [](Scenario& s) {
                  s.initial_velocity = {0.3, 0.4};
                }),
           ends_at("stops after u^2/(2 mu g)", {0.6 * path, 0.8 * path}));
}

}  // namespace

std::vector<ExtremeCase> extreme_cases(bool quick) {
  Scenario slips;
  slips.friction = {0.1, 0.0125, 0.5, pi / 2, 0};
  slips.cycles = quick ? 2 : 20;
  const Scenario sticks = with(slips, [](Scenario& s) { s.friction = {0.122, 0.122 / 8, 0.5, pi / 6, 0}; });
  ExtremeList list{quick};
  list.add("ordinary", slips);
  list.add("ordinary, sticks", sticks);
  add_of_regime(list, slips, "slips");
  add_of_regime(list, sticks, "sticks");
  add_thresholds(list, slips);
  add_drives(list, slips, sticks);
  return std::move(list.cases);
}

}  // namespace tribotrack::bench
