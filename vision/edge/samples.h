// Sample covariances of rays about each sector of the rim, and what is learnt from them.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "vision/edge/optics.h"

namespace tribotrack::vision {

// Series split into bands of time: what changes from frame to frame, what changes over some frames, and what
// changes slowly. The bands of a series add up to it.
//
// Lamps and what turns under them change slowly, noise does not: where an error comes from is told by its
// band.

inline constexpr std::size_t kBands = 3;  ///< fast, middle, slow

/// `rows` rows of `width` numbers, one row a frame; consecutive blocks of rows are filtered apart.
/// `block_ends` are rows, the last of them `rows`.
using Bands = std::array<std::vector<float>, kBands>;
Bands split_bands(const std::vector<float>& series, std::size_t width,
                  std::span<const std::size_t> block_ends);

/// Share of white noise's variance that lies in each band of such blocks.
std::array<double, kBands> noise_shares(std::span<const std::size_t> block_ends);

inline constexpr std::size_t kSectors = 16;  ///< of the rim

/// Of the mean picture or of a band.
struct RaySamples {
  std::vector<Eigen::MatrixXd> covariances;  ///< about the first ray of each sector, or of all of them
  double noise_variance = 0;                 ///< grey levels^2
};

/// Of the rays of the mean of so many frames, each of that noise: one covariance of all sectors, for the
/// rim's optics are the same all round, whatever its levels.
RaySamples samples_of_mean(const RayGrid& grid, const std::vector<float>& mean, double noise_variance,
                           std::size_t frames);

/// Of each band of `levels`, RayGrid::size() numbers a frame; see split_bands().
std::vector<RaySamples> samples_of_bands(const RayGrid& grid, const std::vector<float>& levels,
                                         double noise_variance, std::span<const std::size_t> block_ends);

/// The rim's optics of greatest likelihood for the rays of the mean picture, which all share them whatever
/// their levels: from the best of `starts` downhill along the axes.
RimOptics likeliest_optics(const RayFields& fields, const RaySamples& mean,
                           const std::vector<RimOptics>& starts,
                           RayFields::Beside beside = RayFields::Beside::nothing);
/// A coarse grid about a circle that is known to a pixel.
std::vector<RimOptics> optics_about(const RimOptics& start, double radius);

}  // namespace tribotrack::vision
