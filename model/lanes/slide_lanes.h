// Sliding on a circling platform, many parts side by side: one lane of the processor's vectors for each.
#pragma once

namespace tribotrack::model::internal {

/// In the frame that turns with the drive, in units of the drive's length a and of its phase t, a part under
/// constant friction kappa = mu g/a obeys an equation without time in it: the velocity v, the displacement z
/// as seen from that frame, and the speed r = |v|,
///   v' = 1 - kappa n - i v,   z' = v - i z,   r' = n_x - kappa,   n = v/r   (the drive along the real axis).
/// Neighbouring motions, by dv = u and dz = y:
///   u' = -(kappa/r) e (e.u) - i u,   y' = u - i y,   e = i n.
struct SlideLanes {
  static constexpr int kWidth = 8;
  using Lane = double[kWidth];
  alignas(64) Lane kappa, left;     ///< friction; phase left until it changes
  alignas(64) Lane tolerance;       ///< of v, absolute, each step
  alignas(64) Lane vx, vy, zx, zy;  ///< motion
  alignas(64) Lane ux[2], uy[2];    ///< of two neighbours
  alignas(64) Lane yx[2], yy[2];
};

/// Carries every lane on by one step of its own length, at most to where its friction changes (left = 0). The
/// lanes are independent: results do not depend on which runs share a vector.
using SlideStep = void (*)(SlideLanes& lanes);

/// Of the motion alone, and with two neighbours.
struct SlideSteps {
  SlideStep alone = nullptr, with_neighbours = nullptr;
};

struct SlideMachines {
  SlideStep start = nullptr;  ///< from v = 0 where kappa < 1; has no neighbours
  SlideSteps slide;           ///< Taylor series in t: its steps shrink with the speed
  /// Taylor series in sigma, dt = r dsigma: for low speeds, comes to a stop exponentially. A lane that would
  /// pass its end by this step is left where it was, with the sign of `left` changed.
  SlideSteps creep;
};

}  // namespace tribotrack::model::internal
