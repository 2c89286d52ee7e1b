// The rectangular function that controls dry friction dynamically, eq. (6).
#pragma once

namespace tribotrack::model {

/// Kilikevicius et al. 2021, eq. (6), with the actuator's phase lag: the coefficient is mu2 while
///   phi + lag + 2 pi n < wt < phi + lag + dtau + 2 pi n   for any integer n,
/// else mu1. phi is the commanded phase; the friction follows the command `lag` later. Values are not checked
/// here: Scenario::validate() does.
///   const Friction f{0.1, 0.0125, 0.5, M_PI / 2, 0.1};
///   f.coefficient(0.7);  // 0.0125: within (0.6, 0.6 + pi/2)
struct Friction {
  double nominal = 0.1;     ///< mu1, >= 0.
  double reduced = 0.0125;  ///< mu2, >= 0.
  double phase = 0;         ///< phi, rad, as commanded.
  double pulse_width = 0;   ///< dtau, rad, in [0, 2 pi].
  double lag = 0;           ///< the actuator's phase lag, rad.

  /// mu at the platform phase wt. On an edge the value that holds just after it.
  double coefficient(double wt) const;
};

/// Share of the phase interval [from, to] (rad, from < to) during which the commanded pulse of eq. (6) is on:
/// phi + 2 pi n < wt < phi + dtau + 2 pi n, without the actuator's lag. 0 .. 1.
double gate_share(const Friction& friction, double from, double to);

}  // namespace tribotrack::model
