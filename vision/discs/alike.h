// Which of the discs in a picture are alike: of equal right to be the part.
#pragma once

#include <span>
#include <vector>

#include "vision/discs/disc_detection.h"

namespace tribotrack::vision {

inline constexpr double kAsLarge = 0.75;  ///< ratio of the radii of discs that are alike, at least

/// As large, to a quarter, and seen nearly as well; or as large to a tenth, of the same contrast and seen at
/// all (a neighbour may touch its rim).
bool alike(const DiscFit& other, const DiscFit& part);

/// `part` and the others that are alike, from left to right; what lies within the part's rim is not another.
std::vector<Circle> discs_alike(std::span<const DiscFit> found, const DiscFit& part);

/// The nearest to a given place of the discs that are about as large: radius within a third. Null if none is.
const DiscFit* nearest_like(std::span<const DiscFit> found, const Circle& given);

}  // namespace tribotrack::vision
