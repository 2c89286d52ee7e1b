// The median, and the spread about it.
#pragma once

#include <algorithm>
#include <iterator>

namespace tribotrack::vision {

/// Standard deviation of normal numbers per median of their absolute deviations, 1 / Phi^-1(3/4).
inline constexpr double kNormalMad = 1.4826;

/// The middle value, of an even count the upper of the two in the middle, of none 0. Reorders what it is
/// given.
auto median(auto&& values) {
  using Number = std::decay_t<decltype(*std::begin(values))>;
  const auto count = std::distance(std::begin(values), std::end(values));
  if (count == 0) return Number{};
  const auto middle = std::next(std::begin(values), count / 2);
  std::nth_element(std::begin(values), middle, std::end(values));
  return *middle;
}

}  // namespace tribotrack::vision
