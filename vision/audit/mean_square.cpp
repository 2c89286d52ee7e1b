#include "vision/audit/mean_square.h"

#include <cmath>
#include <limits>

#include "vision/kernels/median.h"

namespace tribotrack::vision {

double outlier_size(const std::vector<double>& numbers) {
  constexpr double kFar = 5;
  constexpr double kMostOutliers = 0.25;
  std::vector<double> sizes;
  for (const double z : numbers) sizes.push_back(std::abs(z));
  const double limit = kFar * kNormalMad * median(sizes);
  double beyond = 0;
  for (const double size : sizes) beyond += size > limit;
  return beyond > kMostOutliers * static_cast<double>(sizes.size()) ? std::numeric_limits<double>::infinity()
                                                                    : limit;
}

double supported(const MeanSquare& found) {
  const double excess = found.value - 1;
  const double doubt = 2 * found.scatter;
  if (!(excess > doubt)) return 1;
  return 1 + excess - doubt * doubt / excess;
}

}  // namespace tribotrack::vision
