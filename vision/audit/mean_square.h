// A mean of squares, how well it is known, and how much of it is beyond doubt.
#pragma once

#include <vector>

namespace tribotrack::vision {

/// Of numbers that a right model scales to a variance of 1.
struct MeanSquare {
  double value = 1;
  double scatter = 0;  ///< standard deviation of the value
};

/// The least size a number of these must have to be an outlier: five standard deviations as the median size
/// tells them; infinite where more than a quarter are larger, which are then no outliers.
double outlier_size(const std::vector<double>& numbers);

/// What a covariance must be multiplied by, 1 or more, for the sake of an excess x = value - 1 that is known
/// to the scatter s: 1 + x (1 - (2 s / x)^2) from x = 2 s on, else 1 (Breiman's non-negative garrote,
/// Technometrics 37, 1995). A right model is widened in one case of 44, and then by little; a large excess is
/// taken as it is.
double supported(const MeanSquare& found);

}  // namespace tribotrack::vision
