// Series split into bands of time: what changes from frame to frame, what changes over some frames, and what
// changes slowly. The bands of a series add up to it.
//
// Lamps and what turns under them change slowly, noise does not: where an error comes from is told by its
// band.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace tribotrack::vision {

inline constexpr std::size_t kBands = 3;  ///< fast, middle, slow

/// `rows` rows of `width` numbers, one row a frame; consecutive blocks of rows are filtered apart.
/// `block_ends` are rows, the last of them `rows`.
using Bands = std::array<std::vector<float>, kBands>;
Bands split_bands(const std::vector<float>& series, std::size_t width,
                  std::span<const std::size_t> block_ends);

/// Share of white noise's variance that lies in each band of such blocks.
std::array<double, kBands> noise_shares(std::span<const std::size_t> block_ends);

}  // namespace tribotrack::vision
