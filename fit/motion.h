// Which motion a track shows, before anything is measured: a part may be driven, slide to rest, run down an
// incline, swing, be pulled, or rest, and each allows different conclusions.
//
//   const ShownMotion shown = shown_motion(track);
//   if (shown.kind == MotionKind::slide) ...                     // mu1 = deceleration / g may be asked for
//   if (shown.oscillation) std::printf("%g rad/s\n", shown.oscillation->angular_frequency.value);
//
// Simple motions are compared with the points; none relies on the points' sds:
//   rest        all within 10 sd of the points;
//   line at w   of what moves faster than w/2 more than half stands in one line of the spectrum, above noise.
//               Three cycles at least; where the cycles are fewer than five, a cubic and a sinusoid must
//               leave less than a twentieth of what a cubic leaves. Vibration of the camera is none: a
//               line below the noise of a part at rest, or below 1 % of the way of one that is braked;
//   braking     p(t) = p0 + v (x - x^2/2 - q (x^2/2 - x^3/3)) ts,  x = min(t/ts, 1), |q| <= 2/3:
//               the velocity falls to 0 at ts, its fall in the first and in the second half differ by no more
//               than a factor of two, and of the squares that a straight line leaves it leaves less than a
//               hundredth beyond noise (80 real slides: 0.3 hundredths at most). Read backwards it is a part
//               let go on an incline;
//   pull        it goes on in one direction, and none of the above.
#pragma once

#include <cstddef>
#include <optional>

#include "fit/measurement.h"
#include "fit/track_table.h"

namespace tribotrack::fit {

enum class MotionKind { unknown, at_rest, driven, swinging, slide, incline, pulled, with_background };

/// "driven", "at rest", "slide to rest", ...
const char* to_string(MotionKind kind);

/// A periodic motion.
struct Oscillation {
  Estimate angular_frequency;   ///< rad/s
  double cycles = 0;            ///< in the track
  double major = 0, minor = 0;  ///< m, semi-axes of the ellipse
  double last_over_first = 1;   ///< amplitude in the last third of the track over that in the first
  double drift = 0;             ///< m, displacement from the first cycle to the last
};

/// A constant deceleration.
struct EvenBraking {
  double deceleration = 0;          ///< m/s^2, its mean; of an incline < 0
  double speed = 0;                 ///< m/s, where it is fastest
  std::size_t first = 0, last = 0;  ///< rows [first, last)
};

struct ShownMotion {
  MotionKind kind = MotionKind::unknown;
  double way = 0;                          ///< m, farthest from the first point
  double noise = 0;                        ///< m, sd of a point per axis
  double speed = 0;                        ///< m/s, way over time
  std::optional<Oscillation> oscillation;  ///< driven, swinging
  std::optional<EvenBraking> braking;      ///< slide, incline
};

/// In the frame of the track's positions. Linear in the number of points, but for ln.
ShownMotion shown_motion(const TrackTable& track);

}  // namespace tribotrack::fit
