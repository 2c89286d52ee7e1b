// Tracks of free slides made without the model under test: brute-force friction of the face, white noise.
#pragma once

#include <cmath>
#include <random>

#include "fit/problem.h"
#include "model/spinning_disc.h"

namespace tribotrack::test {

/// What a camera sees of a sliding disc.
struct SlideLook {
  double mu = 0.17, speed = 0.6, angle = 0.4;  ///< m/s, rad
  double radius = 15.5e-3, rate = 240;         ///< m, Hz
  double sigma = 30e-6, sigma_angle = 0.01;    ///< m, rad
  double bearing = 1;                          ///< of the radius, share on which it bears
  double rest_after = 0.05;                    ///< s
};

inline fit::TrajectoryRun slide_track(const UnitSlide& motion, double spin_ratio, const SlideLook& look,
                                      std::mt19937& random, bool with_angle = true) {
  fit::TrajectoryRun run;
  run.name = "slide";
  run.free_slide = true;
  run.scenario.drive.amplitude = run.scenario.drive.amplitude_y = 0;
  const double time_unit = look.speed / (look.mu * run.scenario.drive.gravity), way = look.speed * time_unit;
  std::normal_distribution<double> normal;
  run.track.radius = look.radius;
  for (int k = 0; k / look.rate < motion.stop_time() * time_unit + look.rest_after; ++k) {
    const double t = k / look.rate, s = way * motion.x(t / time_unit);
    run.track.time.push_back(0.7 + t);
    run.track.frame.push_back(168 + k);
    const double x = s * std::cos(look.angle) + look.sigma * normal(random);
    const double y = s * std::sin(look.angle) + look.sigma * normal(random);
    run.track.position.emplace_back(x, y);
    run.track.covariance.push_back(look.sigma * look.sigma * Eigen::Matrix2d::Identity());
    if (!with_angle) continue;
    const double turned =
        spin_ratio == 0 ? 0 : way * motion.rim(t / time_unit) / (look.radius * look.bearing);
    run.track.angle.push_back(1 + turned + look.sigma_angle * normal(random));
    run.track.angle_sigma.push_back(look.sigma_angle);
  }
  return run;
}

}  // namespace tribotrack::test
