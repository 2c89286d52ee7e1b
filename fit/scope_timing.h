// Timing from an oscilloscope: the platform's reference pulses and the actuator's bursts.
//
//   const ScopeEvents events = find_scope_events(trace, {.carrier_hz = 5890});
//   if (const auto sensor = sensor_clock(events, {}))
//     if (const auto gate = gate_from_scope(events, sensor->clock); gate.timing)
//       std::printf("phi %g, dtau %g rad\n", gate.timing->phi.value, gate.timing->dtau.value);
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "fit/gate_timing.h"

namespace tribotrack::fit {

/// Evenly sampled voltages; sample n is taken at start + n increment. A channel that was not recorded is
/// empty.
struct ScopeTrace {
  double start = 0, increment = 0;  ///< s, in the oscilloscope's time (0 = its trigger)
  std::vector<double> sensor;       ///< V, one pulse a turn when the platform is at wt = 0
  std::vector<double> actuator;     ///< V, a carrier that is on while the gate is open
};

struct ScopeOptions {
  double carrier_hz = 5890;    ///< of the actuator's bursts
  double sensor_delay = 0;     ///< s by which the sensor's pulse comes after wt = 0 (its filter)
  double sensor_delay_sd = 0;  ///< s
};

/// Edges in the oscilloscope's time, interpolated between samples.
struct ScopeEvents {
  std::vector<double> pulses;    ///< s, rising edges of the sensor at half its height, delay taken off
  std::vector<double> openings;  ///< s, of the bursts
  std::vector<double> closings;
};

/// Pulses: upward crossings of half the height, with a hysteresis of a tenth. Bursts: the rectified carrier
/// is averaged over one carrier period (its ripple has exactly that period, so it vanishes), and crosses half
/// of its lit level. An edge is crossed half-way through the average, so the average's delay cancels.
/// Throws DataError if a recorded channel shows none.
ScopeEvents find_scope_events(const ScopeTrace& trace, const ScopeOptions& options);

/// w and wt = 0 from the pulses: t_n = t_0 + 2 pi n / w, least squares.
struct SensorClock {
  Estimate angular_frequency;  ///< rad/s
  PhaseClock clock;            ///< in the oscilloscope's time; its sd holds that of the delay
  double scatter = 0;          ///< s rms of single pulses
};
std::optional<SensorClock> sensor_clock(const ScopeEvents& events, const ScopeOptions& options);

/// phi and dtau from the bursts' edges by that clock: means over the bursts, with their scatter. `tie_sd`: s,
/// how well the clock's time and the oscilloscope's are tied.
GateMeasurement gate_from_scope(const ScopeEvents& events, const PhaseClock& clock, double tie_sd = 0);

}  // namespace tribotrack::fit
