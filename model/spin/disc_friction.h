// Coulomb friction of a disc that slides and spins at once, averaged over its face.
//
// Every point of the face is braked against its own velocity. With u the speed of the centre, w = omega R the
// rim's about it, pressure the same everywhere and <> the mean over the face, friction is the gradient of
// mu g Phi, Phi(u, w) = <|u + omega x r|>:
//   force per mass = mu g dPhi/du,   torque per mass and R = mu g dPhi/dw.
// In terms of m, the square of the smaller speed over the larger one, these are hypergeometric functions
// (complete elliptic integrals; Farkas, Bartels, Unger, Wolf, Phys. Rev. Lett. 90, 248302, 2003):
//   dPhi/du = u/max(u, w) F(1/2, -1/2; 2; m)
//   dPhi/dw = w/u 1/4 F(1/2, 1/2; 3; m) for w <= u,  2/3 F(-3/2, 1/2; 1; m) for w >= u.
// Without spin the force is that of a point, mu g; a spinning disc is braked less. Both functions have a
// continuous slope in m, also where u = w.
#pragma once

#include "model/equation/jet.h"

namespace tribotrack::model::internal {

/// A function of m and its slope by m.
struct WithSlope {
  double value = 0, slope = 0;
};

/// F(1/2, -1/2; 2; m), 0 <= m <= 1: 1 down to 8/(3 pi).
WithSlope face_drag(double m);
/// 1/4 F(1/2, 1/2; 3; m): the torque over w/u where the disc slides faster than it spins.
WithSlope slow_spin_brake(double m);
/// 2/3 F(-3/2, 1/2; 1; m): the torque where it spins faster than it slides.
WithSlope fast_spin_brake(double m);

/// Friction per mu g as multiples of the two velocities: force = drag (ux, uy), torque = brake w. Both are
/// smooth where one velocity vanishes.
template <class T>
struct Braking {
  T drag, brake;
};

inline double carry(double, const WithSlope& f) {
  return f.value;
}
template <int N>
Jet<N> carry(const Jet<N>& m, const WithSlope& f) {
  return chain(m, f.value, f.slope);
}

/// From u^2 and w^2, not both 0.
template <class T>
Braking<T> braking(const T& u_square, const T& w_square) {
  using std::sqrt;
  if (value(w_square) <= value(u_square)) {
    const T m = w_square / u_square, speed = sqrt(u_square);
    return {carry(m, face_drag(value(m))) / speed, carry(m, slow_spin_brake(value(m))) / speed};
  }
  const T m = u_square / w_square, speed = sqrt(w_square);
  return {carry(m, face_drag(value(m))) / speed, carry(m, fast_spin_brake(value(m))) / speed};
}

}  // namespace tribotrack::model::internal
