// Laws of the extreme cases; the extremes of friction, of its place against the drive a = A w^2, and of the
// pulse: no width, full width, edges on the cycle's boundary and on each other, huge phases; and those of the
// drive and of the start.
#include "apps/bench/extremes.h"

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

/// What the cases start from, and where they go.
struct ExtremeList {
  struct Regime {
    std::string name;
    Scenario base;
  };
  bool quick = false;
  Regime slip, stick;
  std::vector<ExtremeCase> cases = {};

  explicit ExtremeList(bool only_quick) : quick(only_quick) {
    slip.name = "slips";
    slip.base.friction = {0.1, 0.0125, 0.5, pi / 2, 0};
    slip.base.cycles = quick ? 2 : 20;
    stick = slip;
    stick.name = "sticks";
    stick.base.friction = {0.122, 0.122 / 8, 0.5, pi / 6, 0};
  }
  void add(std::string name, const Scenario& scenario, ExtremeLaw law) {
    cases.push_back({std::move(name), scenario, std::move(law)});
  }
  /// For both regimes: `make(base)` changes a copy of the base, `law(base, scenario)` says what must hold.
  template <class Make, class Law>
  void add_both(const std::string& name, Make make, Law law) {
    for (const Regime* regime : {&slip, &stick}) {
      Scenario scenario = regime->base;
      make(scenario);
      add(name + ", " + regime->name, scenario, law(regime->base, scenario));
    }
  }
};

/// Other amplitudes and frequencies, with friction that follows the drive (both regimes) and with the
/// ordinary friction.
void add_scales(ExtremeList& list) {
  struct Scale {
    const char* name;
    double amplitude, angular_frequency;
  };
  const Drive& usual = list.slip.base.drive;
  for (const Scale& scale :
       {Scale{"w = 1e-3 rad/s", usual.amplitude, 1e-3}, Scale{"w = 1e5 rad/s", usual.amplitude, 1e5},
        Scale{"A = 1 nm", 1e-9, usual.angular_frequency}, Scale{"A = 1 m", 1, usual.angular_frequency}}) {
    const auto rescale = [&](Scenario& s) {
      s.drive.amplitude = s.drive.amplitude_y = scale.amplitude;
      s.drive.angular_frequency = scale.angular_frequency;
    };
    list.add_both(
        scale.name,
        [&](Scenario& s) {
          const double before = drive_strength(s);
          rescale(s);
          s.friction.nominal *= drive_strength(s) / before;
          s.friction.reduced *= drive_strength(s) / before;
        },
        [](const Scenario&, const Scenario&) { return scaling_law(); });
    Scenario fixed = list.slip.base;
    rescale(fixed);
    const bool held = drive_strength(fixed) < fixed.friction.reduced * fixed.drive.gravity;
    list.add(std::string(scale.name) + ", mu1 = 0.1", fixed, held ? never_moves() : scaling_law());
  }
}

void add_ellipses(ExtremeList& list) {
  const auto add = [&](const std::string& name, double epsilon, auto law) {
    list.add_both(
        name, [&](Scenario& s) { s.drive.phase_shift = epsilon; },
        [&](const Scenario& base, const Scenario& s) { return law(base, s); });
  };
  const auto on_line = [](double slope) {
    return [slope](const Scenario&, const Scenario&) { return stays_on_line(slope); };
  };
  const auto as_at = [](const char* text, double epsilon, double allowed) {
    return [=](const Scenario&, const Scenario& s) {
      Scenario other = s;
      other.drive.phase_shift = epsilon;
      return same_as(text, other, allowed);
    };
  };
  add("epsilon = 0", 0, on_line(1));
  add("epsilon = pi", pi, on_line(-1));
  add("epsilon = 1e-8", 1e-8, as_at("as at 0", 0, 1e-6));
  add("epsilon = pi/2 + 1e-12", pi / 2 + 1e-12, as_at("as at pi/2", pi / 2, 1e-10));
  add("epsilon = pi/2 - 1e-12", pi / 2 - 1e-12, as_at("as at pi/2", pi / 2, 1e-10));
  // Counter-clockwise is the mirror image of cos(wt + pi/2).
  add("epsilon = -pi/2", -pi / 2, [](const Scenario& base, const Scenario&) {
    const Vector2d end = end_of(base);
    return ends_at("mirror image of pi/2", {end.x(), -end.y()});
  });
}

/// Tilted so that the drive grows smoothly through friction once a cycle: by ever less.
void add_smooth_take_offs(ExtremeList& list) {
  for (const double tilt : {0.03, 0.0078, 0.00744}) {
    Scenario s = list.stick.base;
    s.friction.nominal = 0.12;
    s.friction.pulse_width = 0;
    s.drive.tilt_x = tilt;
    list.add("takes off smoothly, tilt " + number(tilt), s, scaling_law());
  }
}

void add_tilts(ExtremeList& list) {
  for (const double offset : {1e-6, 1e-9})
    for (const double side : {-1.0, 1.0}) {
      const std::string where = number(offset) + (side < 0 ? " below sliding" : " above sliding");
      // At rest on a tilted platform.
      Scenario s = list.slip.base;
      const double g = s.drive.gravity;
      s.drive.amplitude = s.drive.amplitude_y = 0;
      s.friction.pulse_width = 0;
      s.drive.tilt_x = std::asin(s.friction.nominal * (1 + side * offset));
      s.duration = 2;
      const double left = g * std::sin(s.drive.tilt_x) - s.friction.nominal * g;
      if (side < 0)
        list.add("A = 0, tilt " + where, s, never_moves());
      else  // the difference of two nearly equal numbers: good to epsilon / offset
        list.add("A = 0, tilt " + where, s,
                 ends_at("slides (g sin tilt - mu g) t^2/2", {0.5 * left * s.duration * s.duration, 0},
                         1e-15 / offset));
      // On a shaken one: where drive and tilt add up to friction, and where the tilt alone does.
      s = list.stick.base;
      s.friction.pulse_width = 0;
      const double a = drive_strength(s), m = s.friction.nominal * g;
      s.drive.tilt_x = std::asin((m * (1 + side * offset) - a) / g);
      const double surplus = a + g * std::sin(s.drive.tilt_x) - m;
      list.add("drive + tilt " + where, s, side < 0 ? never_moves() : creeps_at_most(surplus));
      for (const auto* regime : {&list.slip, &list.stick}) {
        s = regime->base;
        s.drive.tilt_y = std::asin(s.friction.nominal * (1 + side * offset));
        list.add("shaken, tilt " + where + ", " + regime->name, s, scaling_law());
      }
    }
}

void add_drive_extremes(ExtremeList& list) {
  add_ellipses(list);
  add_scales(list);
  add_smooth_take_offs(list);
  add_tilts(list);
}

void add_start_extremes(ExtremeList& list) {
  // A drive along a line, the velocity against it and slightly beside it: u misses 0 by about `miss`.
  for (const double miss : {1e-3, 1e-8, 1e-14})
    for (const double side : {1.0, -1.0}) {
      const auto start = [](double beside) {
        return [beside](Scenario& s) {
          const Vector2d along = Vector2d(1, 1).normalized(), across = Vector2d(-1, 1).normalized();
          const double speed = s.drive.amplitude * s.drive.angular_frequency;
          s.drive.phase_shift = 0;
          s.initial_velocity = speed * (-0.3 * along + beside * across);
        };
      };
      list.add_both("u misses 0 by " + number(side * miss) + " of A w", start(side * miss),
                    [&](const Scenario& base, const Scenario&) {
                      Scenario through = base;
                      start(0)(through);
                      return never_separates_from(through);
                    });
    }
  list.add_both(
      "initial speed 1e-300 m/s",
      [](Scenario& s) {
        s.initial_velocity = {1e-300, 0};
      },
      [](const Scenario& base, const Scenario&) { return same_as("as from rest", base, 1e-11); });
  for (const double speed : {1e-17, 1e-8})
    list.add_both(
        "initial speed " + number(speed) + " m/s",
        [speed](Scenario& s) {
          s.initial_velocity = {speed, speed / 3};
        },
        [](const Scenario& base, const Scenario&) { return never_separates_from(base); });
  list.add_both(
      "initial speed 1e3 m/s",
      [](Scenario& s) {
        s.initial_velocity = {1e3, 0};
      },
      [](const Scenario&, const Scenario&) { return scaling_law(); });
  Scenario slide = list.slip.base;
  slide.drive.amplitude = slide.drive.amplitude_y = 0;
  slide.friction.pulse_width = 0;
  slide.initial_velocity = {0.3, 0.4};
  slide.duration = 2;
  const double path = 0.25 / (2 * slide.friction.nominal * slide.drive.gravity);  // u^2 / (2 mu g) along u
  list.add("A = 0, free slide to its stop", slide,
           ends_at("stops after u^2/(2 mu g)", {0.6 * path, 0.8 * path}));
  // How rounding grows with the number of cycles is in the violations of these.
  for (const double cycles : list.quick ? std::vector<double>{100} : std::vector<double>{1e2, 1e4, 1e6})
    list.add_both(
        number(cycles) + " cycles", [&](Scenario& s) { s.cycles = cycles; },
        [](const Scenario&, const Scenario&) { return last_half_adds_drifts(); });
}

Scenario with_mu(Scenario s, double mu1, double mu2) {
  s.friction.nominal = mu1;
  s.friction.reduced = mu2;
  return s;
}

Scenario without_pulses(Scenario s) {
  s.friction.pulse_width = 0;
  return s;
}

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

}  // namespace

std::vector<ExtremeCase> extreme_cases(bool quick) {
  ExtremeList list(quick);
  list.add("ordinary", list.slip.base, scaling_law());
  list.add("ordinary, sticks", list.stick.base, scaling_law());
  add_friction_extremes(list);
  add_threshold_extremes(list);
  add_pulse_extremes(list);
  add_drive_extremes(list);
  add_start_extremes(list);
  return std::move(list.cases);
}

}  // namespace tribotrack::bench
