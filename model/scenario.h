// Everything one run of the friction model needs, and the names of its parameters.
//
// A part lies on a horizontal platform that oscillates in its own plane, eq. (1) of Kilikevicius et al. 2021.
// With u the part's velocity relative to the platform, its motion obeys eq. (5),
//   du/dt = d(wt) - mu(wt) g u/|u|  while it slips (u != 0),
//   u = 0                           while it sticks, that is as long as |d(wt)| <= mu(wt) g,
// with the drive d (drive.h) and the pulsed friction coefficient mu of eq. (6) (friction.h). Mass does not
// matter. x points right, y up; all quantities are in SI units, angles in rad.
//   Scenario s;                                     // the paper's conditions: A = 0.28 mm, w = 62.8 rad/s
//   s.friction = {0.1, 0.0125, 0, M_PI / 2, 0};     // mu1, mu2, phi, dtau, lag
//   const Trajectory run = integrate(s);            // trajectory.h: 20 cycles from rest
//   const double alpha = displacement_angle(run.end().position);  // alpha_v.h
#pragma once

#include <Eigen/Core>
#include <stdexcept>

#include "model/drive.h"
#include "model/friction.h"

namespace tribotrack::model {

/// How a run starts, at its first analysed frame. The periodic motions are found by steady_orbit().
enum class Start {
  rest,      ///< u = initial_velocity (default 0) relative to the platform
  circling,  ///< the periodic motion at constant mu1, until the first pulse opens
  steady,    ///< the periodic motion with pulses
};

/// A parameter of the model with respect to which it can be differentiated.
enum class Parameter {
  mu1,
  mu2,
  lag,
  phi,
  dtau,
  amplitude,
  amplitude_y,
  angular_frequency,
  phase_shift,
  gravity,
  tilt_x,
  tilt_y,
  velocity_x,
  velocity_y,  ///< components of the initial velocity
  start_phase,
  spin,     ///< of a free slide: initial rate of turning
  inertia,  ///< and I/(m R^2)
  viscous
};

/// A parameter out of its range or not a number. `what()` names parameter, value and range.
class InvalidParameter : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

/// How a part that slides freely also turns: an even disc braked by Coulomb friction over its whole face,
/// evenly pressed. Friction then acts on each point against that point's own velocity, and a spinning disc is
/// braked less: at a rim speed of half the speed of sliding by 3 %, at the same speed by 15 %.
struct Spin {
  double rate = 0;       ///< rad/s at the start, counter-clockwise (y up)
  double radius = 0;     ///< of the face, m; needed where it spins
  double inertia = 0.5;  ///< I/(m R^2): 1/2 for an even disc, 1 for a ring
};

/// One run. Time t is 0 at its start; the platform phase is wt = start_phase + w t.
struct Scenario {
  Drive drive;
  Friction friction;
  Start start = Start::rest;
  double start_phase = 0;  ///< rad
  Eigen::Vector2d initial_velocity =
      Eigen::Vector2d::Zero();  ///< m/s, relative to the platform; start = rest only
  /// A spinning part: the platform rests (A = A_y = 0, no pulses, start = rest); only integrate() follows it.
  Spin spin;
  /// 1/s: friction takes viscous |u| beside mu g from the speed |u|, every point of a spinning part by its
  /// own. Of free slides only, like spin; a negative one, which a fit may try, is taken as it stands.
  double viscous = 0;
  /// The run ends after `duration` seconds or, where that is 0, after `cycles` platform periods, N 2 pi / w;
  /// then derivatives of the end point with respect to w count the end time's own dependence on w.
  double duration = 0;
  double cycles = 20;

  /// Throws InvalidParameter naming the parameter (negative mu, g <= 0, dtau outside [0, 2 pi], NaN, ...).
  /// integrate(), steady_orbit() and plan() call it.
  void validate() const;
  /// duration, or cycles * 2 pi / w when duration is 0. s.
  double end_time() const;
  /// The value of a parameter, in SI.
  double get(Parameter parameter) const;
  void set(Parameter parameter, double value);
};

const char* to_string(Parameter parameter);
const char* to_string(Start start);

}  // namespace tribotrack::model
