#include "model/drive.h"

#include <cmath>

namespace tribotrack::model {

Eigen::Vector2d Drive::acceleration(double wt) const {
  const double square = angular_frequency * angular_frequency;
  return Eigen::Vector2d(square * amplitude * std::cos(wt) + gravity * std::sin(tilt_x),
                         square * amplitude_y * std::cos(wt + phase_shift) + gravity * std::sin(tilt_y));
}

Eigen::Vector2d Drive::displacement(double wt) const {
  return Eigen::Vector2d(amplitude * std::cos(wt), amplitude_y * std::cos(wt + phase_shift));
}

}  // namespace tribotrack::model
