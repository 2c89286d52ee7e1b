// The actuator's gate: when it is commanded on.
#pragma once

#include "model/friction.h"

namespace tribotrack::model {

/// Share of the phase interval [from, to] (rad, from < to) during which the commanded pulse of eq. (6) is on:
/// phi + 2 pi n < wt < phi + dtau + 2 pi n, without the actuator's lag. 0 .. 1.
double gate_share(const Friction& friction, double from, double to);

}  // namespace tribotrack::model
