// The companding curve of packed 10-bit Phantom recordings.
#pragma once

#include <array>
#include <cstdint>

namespace tribotrack::vision {

/// 12-bit linear level of each of the 1024 codes. The codes follow about the square root of the light, so
/// that shot noise is a constant number of codes: black (linear 64) is code 64, white (linear 4064) code 1014
/// to 1015. Measured facts of the format, on which the open readers agree; never falling.
extern const std::array<std::uint16_t, 1024> p10_linear_levels;

}  // namespace tribotrack::vision
