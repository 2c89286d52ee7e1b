// Extremes of the drive and of the start.
#include <cmath>
#include <numbers>

#include "apps/bench/extremes.h"

namespace tribotrack::bench {

using namespace model;

namespace {

using Eigen::Vector2d;
using std::numbers::pi;

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

}  // namespace

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

}  // namespace tribotrack::bench
