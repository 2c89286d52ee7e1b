#include "model/friction.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tribotrack::model {

double gate_share(const Friction& friction, double from, double to) {
  constexpr double cycle = 2 * std::numbers::pi;
  // Time on since wt = phi, as a function of wt: whole pulses plus the part of the last one.
  const auto on_since = [&](double wt) {
    const double since = wt - friction.phase;
    const double whole = std::floor(since / cycle);
    return whole * friction.pulse_width + std::min(since - whole * cycle, friction.pulse_width);
  };
  // Rounding must not make a gate that is always on more than that.
  return std::clamp((on_since(to) - on_since(from)) / (to - from), 0.0, 1.0);
}

}  // namespace tribotrack::model
