// A frame's scores: what each sector of the rim says of the shift, in each band of time, and what follows for
// all frames.
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

#include "vision/edge/optics.h"
#include "vision/edge/samples.h"

namespace tribotrack::vision {

/// Of the mean picture: levels and gradient at each place of the grid.
struct MeanRays {
  std::vector<float> level, slope_x, slope_y;
};

/// Generalised least squares of a shift in one band.
struct BandWeights {
  std::vector<float> x, y;                            ///< S^-1 grad M
  std::array<Eigen::Matrix2d, kSectors> information;  ///< sum over a sector of grad M^T S^-1 grad M
  Eigen::Matrix2d shift_per_score = Eigen::Matrix2d::Identity();  ///< A: one over their sum
};
using EdgeWeights = std::array<BandWeights, kBands>;

/// `variances` of the fields about each sector's first ray, linear between.
BandWeights weigh(const RayGrid& grid, const MeanRays& mean, const std::vector<Eigen::MatrixXd>& fields,
                  const std::array<Eigen::VectorXd, kSectors>& variances, std::size_t band,
                  double noise_variance);

/// Numbers of a frame: for each band and sector the sum of S^-1 grad M (I - M), along x and y.
inline constexpr std::size_t kScores = kBands * kSectors * 2;

/// Of the levels of a frame less the mean's.
void score(const RayGrid& grid, const EdgeWeights& weights, const float* levels, float* scores);

/// How far the centre lies from where a frame was sampled, by one band's weights: -A times the scores' sum.
Eigen::Vector2d shift_of_frame(const BandWeights& weights, const float* scores, std::size_t band);

/// The same of every frame of consecutive blocks, kScores numbers a frame, each band by its own weights.
std::vector<Eigen::Vector2d> shifts_by_bands(const EdgeWeights& weights, const Bands& scores);

struct ScoredShifts {
  std::vector<Eigen::Vector2d> shift;
  std::vector<Eigen::Matrix2d> covariance;  ///< px^2: what the sectors' scores disagree by
  double slow_sd = 0,
         slow_frames = 0;  ///< of a coordinate in the slow band, px; frames over which it stays alike
};
/// Of one recording.
ScoredShifts scored_shifts(const EdgeWeights& weights, const std::vector<float>& scores);

}  // namespace tribotrack::vision
