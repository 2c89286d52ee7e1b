// A mass on a plane that is shaken along a line, with dry friction, in closed form from phase to phase: the
// validation case SDND104 of code_aster (manual v5.01.104), which knows nothing of this program.
//
// Along the line the drive is a sin(tau), tau = wt, friction mu g = eta a. From rest at tau = 0:
//   eta >= 1: at rest for ever. Else it comes loose at tau = asin(eta) (+ pi n, if it rests then);
//   a slip from tau_0 in the direction d = +-1:
//     u(tau) = (a/w) (cos tau_0 - cos tau - d eta (tau - tau_0)),
//     x(tau) - x_0 = (a/w^2) ((tau - tau_0) cos tau_0 + sin tau_0 - sin tau - d eta (tau - tau_0)^2/2);
//   it ends where u = 0 again: there it rests if |sin tau| <= eta, else it slips the other way.
// Slip follows slip for ever iff eta < 2/sqrt(pi^2 + 4); then its turning points are at cos tau = +-pi eta/2
// and each way is 2 (a/w^2) sqrt(1 - (pi eta/2)^2).
#pragma once

#include <cmath>
#include <numbers>
#include <vector>

#include "model/scenario.h"

namespace tribotrack::model {

/// In units of a/w and a/w^2, extended precision.
class ShakenPlane {
 public:
  using Real = long double;
  struct Slip {
    Real begin, end;  ///< tau
    int direction;    ///< +1 or -1
    Real place;       ///< x_0
  };
  static constexpr Real kPi = std::numbers::pi_v<Real>;

  /// All slips that begin before tau = `until`.
  ShakenPlane(double eta, Real until) : eta_(eta) {
    if (eta_ >= 1) return;
    Slip slip{std::asin(eta_), 0, 1, 0};
    while (slip.begin < until) {
      slip.end = end_of(slip);
      slips_.push_back(slip);
      const Real at_end = std::sin(slip.end), place = slip.place + way(slip, slip.end);
      if (std::abs(at_end) > eta_)
        slip = {slip.end, 0, -slip.direction, place};
      else
        slip = loose_after(slip.end, place);
    }
  }

  const std::vector<Slip>& slips() const { return slips_; }
  Real position(Real tau) const {
    Real x = 0;
    for (const Slip& slip : slips_)
      if (slip.begin < tau) x = slip.place + way(slip, std::min(tau, slip.end));
    return x;
  }
  Real velocity(Real tau) const {
    for (const Slip& slip : slips_)
      if (slip.begin < tau && tau < slip.end) return speed(slip, tau);
    return 0;
  }
  /// Above it, rests between the slips.
  static Real least_eta_with_rests() { return 2 / std::sqrt(kPi * kPi + 4); }

 private:
  Real speed(const Slip& slip, Real tau) const {
    return std::cos(slip.begin) - std::cos(tau) - slip.direction * eta_ * (tau - slip.begin);
  }
  Real way(const Slip& slip, Real tau) const {
    const Real t = tau - slip.begin;
    return t * std::cos(slip.begin) + std::sin(slip.begin) - std::sin(tau) -
           slip.direction * eta_ * t * t / 2;
  }
  /// The speed grows to where the drive falls to eta, then falls until the drive has grown to eta again one
  /// period later: by then it would have turned.
  Real end_of(const Slip& slip) const {
    const Real half_turn = slip.direction > 0 ? 0 : kPi;
    const Real turn = std::floor((slip.begin - half_turn) / (2 * kPi)) * 2 * kPi + half_turn;
    Real before = turn + kPi - std::asin(eta_), after = turn + 2 * kPi + std::asin(eta_);
    for (int k = 0; k < 200; ++k) {
      const Real middle = (before + after) / 2;
      (slip.direction * speed(slip, middle) > 0 ? before : after) = middle;
    }
    return before;
  }
  Slip loose_after(Real tau, Real place) const {
    const Real half_turns = std::ceil((tau - std::asin(eta_)) / kPi);
    return {std::asin(eta_) + half_turns * kPi, 0, std::fmod(half_turns, 2) == 0 ? 1 : -1, place};
  }

  Real eta_;
  std::vector<Slip> slips_;
};

/// Its scenario: shaken at `angle` (rad) to x, without pulses, 20 cycles.
inline Scenario shaken_plane_scenario(double eta, double angle) {
  Scenario s;
  const double length = s.drive.amplitude;
  s.drive.amplitude = length * std::abs(std::cos(angle));
  s.drive.amplitude_y = length * std::abs(std::sin(angle));
  s.drive.phase_shift = std::cos(angle) * std::sin(angle) < 0 ? std::numbers::pi : 0;
  s.start_phase = (std::cos(angle) < 0 ? 0.5 : -0.5) * std::numbers::pi;
  const double a = length * s.drive.angular_frequency * s.drive.angular_frequency;
  s.friction = {eta * a / s.drive.gravity, eta * a / s.drive.gravity, 0, 0, 0};
  return s;
}

}  // namespace tribotrack::model
