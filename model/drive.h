// The platform's motion, eq. (1), and the force it exerts on a part lying on it.
#pragma once

#include <Eigen/Core>

namespace tribotrack::model {

/// Circularly (or elliptically) oscillating platform, Kilikevicius et al. 2021, eq. (1):
///   xi  = A cos(wt),   eta = A_y cos(wt + epsilon),
/// x right, y up. With A_y = A and epsilon = +pi/2 the platform circles clockwise. In the platform's frame
/// the inertial force per mass is the drive of eq. (5),
///   d(wt) = -(xi'', eta'') + g (sin tilt_x, sin tilt_y)
///         = w^2 (A cos wt, A_y cos(wt + epsilon)) + g (sin tilt_x, sin tilt_y);
/// the paper has no tilt. Values are not checked here: Scenario::validate() does.
struct Drive {
  double amplitude = 0.28e-3;               ///< A, m, >= 0. 0 = platform at rest.
  double amplitude_y = 0.28e-3;             ///< A_y, m, >= 0.
  double angular_frequency = 62.8;          ///< w, rad/s, > 0.
  double phase_shift = 1.5707963267948966;  ///< epsilon, rad.
  double gravity = 9.81;                    ///< g, m/s^2, > 0.
  double tilt_x = 0;                        ///< rad; in-plane gravity g sin(tilt_x) towards +x.
  double tilt_y = 0;                        ///< rad; towards +y.

  /// d at the platform phase wt, m/s^2.
  Eigen::Vector2d acceleration(double wt) const;
  /// (xi, eta) at the platform phase wt, m.
  Eigen::Vector2d displacement(double wt) const;
};

}  // namespace tribotrack::model
