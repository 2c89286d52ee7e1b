#include "vision/layers/evidence.h"

#include <cmath>
#include <limits>
#include <numbers>

#include "vision/kernels/median.h"

namespace tribotrack::vision {

double frame_noise(const std::vector<TimedPoint>& track) {
  std::vector<double> squares;
  for (std::size_t k = 3; k < track.size(); ++k) {
    if (track[k].frame - track[k - 3].frame != 3) continue;
    const auto third = [&](double Point::*c) {
      return track[k].place.*c - 3 * track[k - 1].place.*c + 3 * track[k - 2].place.*c -
             track[k - 3].place.*c;
    };
    squares.push_back(std::pow(third(&Point::x), 2) + std::pow(third(&Point::y), 2));
  }
  if (squares.empty()) return std::numeric_limits<double>::infinity();
  // The square of a normal vector in the plane has its median at 2 ln 2 of the variance of a coordinate.
  return std::sqrt(median(squares) / (2 * std::numbers::ln2 * 20));
}

}  // namespace tribotrack::vision
