// How much of the ground is seen through the disc's rim: w(rho) = 1 - alpha(rho).
#pragma once

#include <vector>

namespace tribotrack::vision {

/// w(rho), 0 inside the rim's reach and 1 outside it, piecewise linear between knots half a pixel apart. It
/// starts as the blurred edge 1 - 0.5 erfc((rho - R) / (sqrt2 s)) and is learnt by regressing what a pixel of
/// the disc shows on the ground beneath it: the intercept is the pixel's own, the slope is common to a ring.
class RimProfile {
 public:
  RimProfile() = default;
  RimProfile(double radius, double blur);

  double at(double rho) const;
  double inner() const { return inner_; }  ///< w = 0 up to here
  double outer() const { return outer_; }  ///< w = 1 from here
  const std::vector<double>& knots() const { return value_; }
  void set_knots(const std::vector<double>& values) { value_ = values; }

  /// One pixel of the disc at a distance rho: its covariance of levels with the ground's, and the ground's
  /// variance, each summed over the frames.
  void add(double rho, double covariance, double variance);
  /// Least squares over all that was added, held to the present profile by a prior of sd 0.1 per knot;
  /// `noise_variance` of one level. Forgets what was added.
  void solve(double noise_variance);

 private:
  struct Place {
    std::size_t knot = 0;
    double fraction = 0;
  };
  Place place(double rho) const;
  double inner_ = 0, outer_ = 0, step_ = 0.5;
  std::vector<double> value_;                      ///< at the knots
  std::vector<double> right_, diagonal_, beside_;  ///< normal equations, tridiagonal
};

}  // namespace tribotrack::vision
