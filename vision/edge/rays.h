// What levels do along a ray across the rim, as a Gaussian process with a hard edge in it.
//
// Levels along a ray are blur * fields: of the top, which ends where the chamfer begins; of the whole part,
// which ends at the edge; of what lies outside, which begins there; of the chamfer, one level; and fine
// texture of the top. Each is a Gaussian process of given correlation length along the ray [Rasmussen,
// Williams, Gaussian Processes for Machine Learning (2006)], so that
//   cov(s, t) = sum_q v_q Q_q(s, t),   Q_q = E m_q K_q m_q E^T,
// with E the blur, m_q the field's mask and K_q its correlation. That fields end at the edge is all that ties
// the centre down: a level that changes inside an edge does not look like an edge that moves, and Q says by
// how much. The variances v_q >= 0 are those of greatest likelihood for sample covariances C of rays,
//   v_q <- v_q sqrt(tr(X Q_q) / tr(S^-1 Q_q)),  X = S^-1 C S^-1,  S = N + sum v_q Q_q  [multiplicative
//   updates: Zhou, Hu,
// Zhou, Lange, "MM algorithms for variance components models", J. Comput. Graph. Stat. 28 (2019)].
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "vision/frame_source.h"
#include "vision/kernels/bspline.h"

namespace tribotrack::vision {

// Frames sampled along rays about the part's centre: place s of ray p lies at radius + s - inside px from the
// centre, in the direction 2 pi p / azimuths.

struct RayGrid {
  double radius = 0;            ///< px, about
  int inside = 7, outside = 4;  ///< px of it that are looked at
  int azimuths = 0;             ///< rays, about one a pixel of the rim
  std::size_t places() const { return static_cast<std::size_t>(inside + outside + 1); }
  std::size_t size() const { return places() * static_cast<std::size_t>(azimuths); }
  /// Of a place from the nominal rim, px.
  double offset(std::size_t place) const { return static_cast<double>(place) - inside; }
  double reach() const { return radius + outside; }
};

RayGrid ray_grid(double radius);

/// Levels ray by ray, RayGrid::size() of them; slopes, if wanted, in grey levels per px along x and y.
struct RayLevels {
  float* level = nullptr;
  float *slope_x = nullptr, *slope_y = nullptr;
};

class RaySampler {
 public:
  explicit RaySampler(const RayGrid& grid);
  /// The window that a sample about `centre` is taken from; not all of it need lie in the picture.
  Rect window(const Point& centre) const;
  /// From the spline of that window.
  void sample(const QuinticSpline& spline, const Rect& window, const Point& centre, const RayLevels& out);

 private:
  RayGrid grid_;
  std::vector<float> along_x_, along_y_, x_, y_;  ///< px from the centre, and in the window
};

/// Of the rim: where the edge is beyond the grid's radius, how wide the lens smears it, how wide its chamfer
/// is, px.
struct RimOptics {
  double edge = 0, blur = 0.85, chamfer = 0.5;
};

class RayFields {
 public:
  /// Fields are constant in cells of so many px; a third of the sharpest blur by default.
  explicit RayFields(const RayGrid& grid, double cell = 0.25);
  /// What may vary along a ray beside top, ground and the chamfer's level: nothing, fields that cross the
  /// chamfer, or the chamfer's own level along the ray.
  enum class Beside { nothing, whole_part, chamfer };
  /// Q_q for a rim.
  std::vector<Eigen::MatrixXd> covariances(const RimOptics& optics, Beside beside) const;

 private:
  int places_, cells_;
  double width_;                                   ///< of a cell, px
  Eigen::VectorXd place_, cell_;                   ///< px from the nominal rim
  std::vector<Eigen::MatrixXd> inside_, outside_;  ///< K_q by correlation length
  Eigen::MatrixXd fine_;
};

/// v_q of one sample covariance, and -2 log of its likelihood per ray less a constant. Starts from
/// `variances` if it holds as many, else from equal ones.
double fit_variances(const Eigen::MatrixXd& sample, const std::vector<Eigen::MatrixXd>& fields,
                     double noise_variance, int iterations, Eigen::VectorXd& variances);

/// sum_q v_q Q_q.
Eigen::MatrixXd field_covariance(const std::vector<Eigen::MatrixXd>& fields,
                                 const Eigen::VectorXd& variances);

// Sample covariances of rays about each sector of the rim, and what is learnt from them.

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
/// rim's optics are the same all round.
RaySamples samples_of_mean(const RayGrid& grid, const std::vector<float>& mean, double noise_variance,
                           std::size_t frames);

/// Of each band of `levels`, RayGrid::size() numbers a frame; see split_bands().
std::vector<RaySamples> samples_of_bands(const RayGrid& grid, const std::vector<float>& levels,
                                         double noise_variance, std::span<const std::size_t> block_ends);

/// One covariance of all sectors; its noise with what no field explains.
RaySamples all_round(const RaySamples& sectors);

struct LikeliestOptics {
  RimOptics optics;
  double cost = 0;  ///< -2 log of the likelihood, per ray, less a constant
};

/// The rim's optics of greatest likelihood for samples of one covariance each, whose rays all share them
/// whatever their levels: from the best of `starts` downhill along the axes, to chamfers up to `widest`.
LikeliestOptics likeliest_optics(const RayFields& fields, std::span<const RaySamples> samples,
                                 const std::vector<RimOptics>& starts,
                                 RayFields::Beside beside = RayFields::Beside::nothing,
                                 double widest = std::numeric_limits<double>::infinity());
/// A coarse grid about a circle that is known to a pixel.
std::vector<RimOptics> optics_about(const RimOptics& start, double radius);

// A frame's scores: what each sector of the rim says of the shift, in each band of time, and what follows for
// all frames.

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

/// How far the centre lies from where a frame was sampled, by its scores of one band: -A times their sum.
Eigen::Vector2d shift(const BandWeights& weights, const float* of_sectors);

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
