// A step of the motion under several laws of friction, one in each lane of a vector.
#pragma once

namespace tribotrack::model::internal {

constexpr int kRivalLanes = 8;

/// A number of each lane.
struct alignas(8 * kRivalLanes) RivalRow {
  double lane[kRivalLanes] = {};
};

/// Relative to the platform, m and m/s.
struct RivalMotion {
  RivalRow x, y, u_x, u_y;
};

/// What friction takes, m/s^2, at the time t since the step began:
///   (level + by_time t + (by_speed + by_speed_time t) |u|) (1 + stribeck exp(-(|u|/fading)^2)) + viscous |u|
struct RivalFriction {
  RivalRow level, by_time, by_speed, by_speed_time, stribeck, fading, viscous;
};

/// The acceleration by the platform and its tilt, m/s^2, and its derivative by time.
struct RivalDrive {
  double x = 0, y = 0, x_rate = 0, y_rate = 0;
};

/// Where in a step the drive is asked for, in shares of it.
inline constexpr double kRivalTimes[] = {0, 0.386, 0.21, 0.63, 1};

struct RivalStepInput {
  RivalMotion from;
  RivalRow moving;  ///< 0: this lane rests, and stays where it is
  RivalFriction friction;
  RivalDrive drive[5];  ///< at kRivalTimes of the step
  double h = 0;         ///< s
  double tolerance = 0, least_position = 0, least_speed = 0;
};

/// By Rosenbrock's method of order 4 (3), L-stable: RODAS in Hairer, Wanner, "Solving Ordinary Differential
/// Equations II", section IV.7. `error`: the greatest of the moving lanes, in units of what is allowed.
void take_rival_step(const RivalStepInput& in, RivalMotion& to, double& error);

}  // namespace tribotrack::model::internal
