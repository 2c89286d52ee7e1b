// When the actuator's gate was open: phi and dtau from the brightness of a gate LED, frame by frame.
//
//   LampRecord lamp{times, levels, 200e-6};                    // s, grey levels, exposure in s
//   PhaseClock clock{motion.angular_frequency.value, motion.phase_at_zero.value, motion.phase_at_middle.sd};
//   const GateMeasurement gate = measure_gate(lamp, clock);
//   if (gate.timing) scenario.friction.phase = gate.timing->phi.value;
//   else std::puts(gate.why_not.c_str());
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "fit/measurement.h"

namespace tribotrack::fit {

/// A gate LED, lit while the gate is open, as the camera saw it.
struct LampRecord {
  std::vector<double> time;        ///< s, middle of each exposure
  std::vector<double> level;       ///< grey levels
  std::optional<double> exposure;  ///< s; unknown where the recording does not say
  bool clipped = false;            ///< the lit lamp saturates: levels show lit, partly lit, not lit only
};

/// The platform's phase as a clock: wt at a time, with the zero of phase that phi is counted from.
struct PhaseClock {
  double angular_frequency = 0;  ///< rad/s
  double phase_at_zero = 0;      ///< rad
  double phase_sd = 0;           ///< rad, of wt at the middle of the recording
  double at(double time) const { return angular_frequency * time + phase_at_zero; }
};

/// phi and dtau as measured: the gate is open while phi + 2 pi n < wt < phi + dtau + 2 pi n.
struct GateTiming {
  Estimate phi;           ///< rad in [0, 2 pi)
  Estimate dtau;          ///< rad
  double covariance = 0;  ///< of phi and dtau, rad^2
  double jitter = 0;      ///< rad rms of single edges about the mean, 0 if none shows
  double bracket = 0;     ///< rad, interval in which no frame locates an edge, the wider of both; 0 if partly
                          ///< lit frames measure the edges
  int cycles = 0;         ///< spanned
  int partly_lit = 0;     ///< frames whose exposure holds an edge
  double off_level = 0, on_level = 0;
  std::string source;  ///< "lamp", "scope"
};

struct GateMeasurement {
  std::optional<GateTiming> timing;
  std::string why_not;  ///< one sentence, where there is none
};

/// One exposure of half-width h = w T / 2 (rad) in the middle of which the phase is theta shows the level
///   b = off + s (on - off),   s = share of [theta - h, theta + h] within the pulses,
/// and s is linear in an edge that lies inside it. The likelihood of an edge is the product over the frames
/// of all cycles of normal densities about that: if exposures overlap the edges it is narrow and normal; if
/// they are short it is a box between the last dark and the first lit phase, narrowed by many cycles
/// sampled at different phases. Value and sd are mean and standard deviation under that likelihood, in both
/// cases and between them. A jitter of the edges from cycle to cycle is a Gaussian convolved with each
/// frame's likelihood (closed form) and is brought in where it raises the likelihood clearly. Each frame
/// may, with probability 1e-4, be an outlier (a flash).
///
/// Opening and closing edge are treated separately, which requires a pulse and a pause longer than one
/// exposure.
GateMeasurement measure_gate(const LampRecord& lamp, const PhaseClock& clock);

}  // namespace tribotrack::fit
