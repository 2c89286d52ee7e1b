// Where the learnt ground lies in a frame.
//
// Minimises sum_x (I(x) - a G(x - p) - b_B(x))^2 / V(x - p) over the displacement p, the light's gain a and
// an offset b_B of each block B of 32 x 32 px, by Gauss-Newton; a and b are solved for in every step (Schur's
// complement), so what light does broadly - flicker, vignetting, a shadow's fringe - draws nothing. The
// ground moves, the picture stays untouched: its noise stays white. Pixels that show something else are
// trimmed.
//
// Covariance: the inverse of the normal matrix, times what the frames of the learning show it to lack
// (`excess`), times the frame's own residual beyond V.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "vision/kernels/bspline.h"
#include "vision/kernels/tile_kernels.h"
#include "vision/picture.h"

namespace tribotrack::vision {

// The platform's ground as learnt from many frames: what registers the others to it.
//
// A frame shows I(x) = a G(x - p) + b(x): G the ground on its own grid, which is that of the first frame's
// pixels, p its displacement since, a the light's gain and b what light adds, smooth over a block of pixels.
// Of a large picture the window that holds the most information is taken.

struct Ground {
  Rect place;          ///< of the window that is learnt, on the ground's grid
  Picture variance;    ///< of a frame's pixel about it, grey levels^2
  Picture seen;        ///< in so many frames; 0 where in too few to be known
  Picture quiet;       ///< the mean freed of its noise, grey levels
  QuinticSpline less;  ///< of `quiet` less `level`
  float level = 0;     ///< mean, taken off before sums are formed
};

/// A frame as far as it may show the ground.
struct GroundFrame {
  std::int64_t index = 0;
  Rect window;                 ///< of the frame
  Picture picture;             ///< in it
  std::vector<Circle> hidden;  ///< the part with its shadow, the lamp
  Point start;                 ///< displacement to refine
};

/// How far the ground lies from where it was learnt.
struct GroundFix {
  Point displacement;                                    ///< px
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  ///< px^2
  double score = 0;             ///< correlation with the learnt ground, what is smooth over a block taken off
  double gain = 1, offset = 0;  ///< of the light: I = gain G + offset
};

class GroundRegistration {
 public:
  /// Keeps a reference.
  explicit GroundRegistration(const Ground& ground);

  /// Nothing where it does not converge within kFarthest of the start.
  std::optional<GroundFix> refine(const GroundFrame& frame, const Point& start);
  static constexpr double kFarthest = 4;  ///< px

  /// Of the last frame refined, at its displacement: the normal matrix of p, and what it would have to be for
  /// the covariance of the blocks' own forces, sum g_B g_B^T, to be right. Both 1/px^2.
  const Eigen::Matrix2d& normal() const { return normal_; }
  const Eigen::Matrix2d& scatter() const { return scatter_; }
  /// Inverse normal matrix to covariance, see the file's head.
  void set_excess(const Eigen::Matrix2d& excess) { excess_ = excess; }

  /// Grey levels rms within blocks, weighted: the ground's own, without noise.
  double texture() const { return texture_; }

 private:
  /// Tiles `first` .. `end` - 1, which lie within 32 x 32 px.
  struct Block {
    std::size_t first = 0, end = 0;
    NormalSums sums{};
  };
  /// Of the columns -a slope_x, -a slope_y, value, offsets taken out.
  struct Fit {
    Eigen::Matrix3d normal;
    Eigen::Vector3d force, solution;
    double squares = 0, of_levels = 0, pixels = 0;
  };
  bool take(const GroundFrame& frame, int whole_x, int whole_y);
  void sample(const Point& fraction);
  std::optional<Fit> solve();
  std::size_t trim(const Fit& fit);
  void note_scatter(const Fit& fit);

  const Ground& ground_;
  std::vector<TilePlace> places_;
  std::vector<Block> blocks_;
  std::vector<float> known_;  ///< 1 / V, 0 where the ground is not known
  std::vector<float> shown_;  ///< of it, what the frame shows
  TileArrays arrays_;         ///< slope_theta holds the level: the fifth column of the sums
  std::vector<const float*> corners_;
  Eigen::Matrix2d normal_, scatter_, excess_ = Eigen::Matrix2d::Identity();
  double texture_ = 0, pixels_ = 0;
};

}  // namespace tribotrack::vision
