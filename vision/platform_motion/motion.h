// The platform's motion from its ground, as much of it as is seen: no mark is needed.
//
//   GroundMotionOptions options;
//   options.noise_variance = camera.noise_variance;
//   options.hidden = [&](std::int64_t index) { return std::vector<Circle>{part_with_shadow(index)}; };
//   if (look_at_ground(sample_ground(source, first, last, kGroundGlance, options), noise_variance).moves)
//     const auto motion = follow_ground(source, first, last, options);
//
// The ground is learnt from frames spread over the recording (learning.cpp), and every frame registered to it
// (GroundRegistration). How well the two directions are known differs where the ground is brushed: along the
// brush less than across. The covariance says it.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <vector>

#include "vision/frame_source.h"
#include "vision/kernels/bspline.h"
#include "vision/kernels/tile_kernels.h"
#include "vision/picture.h"

namespace tribotrack::vision {

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
  /// Keeps a reference. The result is the same for any number of threads.
  explicit GroundRegistration(const Ground& ground, int threads = 1);

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
    std::size_t trimmed = 0;  ///< pixels
  };
  /// Of the columns -a slope_x, -a slope_y, value, offsets taken out.
  struct Fit {
    Eigen::Matrix3d normal;
    Eigen::Vector3d force, solution;
    double squares = 0, of_levels = 0, pixels = 0;
  };
  bool take(const GroundFrame& frame, int whole_x, int whole_y);
  void sample(Block& block, const Point& fraction);
  std::optional<Fit> solve(const Point& fraction);
  std::size_t trim(const Fit& fit);
  std::size_t trim_block(const Block& block, const Fit& fit);
  void note_scatter(const Fit& fit);

  const Ground& ground_;
  int threads_;
  std::vector<TilePlace> places_;
  std::vector<Block> blocks_;
  std::vector<float> known_;  ///< 1 / V, 0 where the ground is not known
  TileArrays arrays_;         ///< slope_theta holds the level: the fifth column of the sums
  std::vector<const float*> corners_;
  Eigen::Matrix2d normal_, scatter_, excess_ = Eigen::Matrix2d::Identity();
  double texture_ = 0, pixels_ = 0;
};

/// Cross-correlation of whole pictures by Fourier transform, the first one under a Hann window and freed of
/// its noise, of which a brushed ground would be located by little else along its brush. What is hidden, what
/// is broad (light) and what stands out too far (things that cross) is taken off. Large pictures are binned.
class CoarseShift {
 public:
  CoarseShift(const Picture& first, const std::vector<Circle>& hidden, double noise_variance);
  /// To within half a bin where the ground shows a texture.
  Point of(const Picture& picture, const std::vector<Circle>& hidden) const;

 private:
  cv::Mat texture(const Picture& picture, const std::vector<Circle>& hidden) const;
  int bin_ = 1;
  cv::Mat first_;  ///< spectrum
};

// A mean picture freed of the noise that is left in it.

/// What is broad (light) by a mean over kBroad px; the rest by Wiener's filter: every spatial frequency is
/// kept by the share of its power that is not the noise's, the power a mean over neighbouring frequencies. A
/// brushed ground lies on few frequencies, so most of the noise goes; slopes of what is left are slopes of
/// the ground. What is not `known` (0) is filled from what is, again and again (Papoulis, IEEE Trans.
/// Circuits Syst. 22, 1975): a step there would look like a texture. `noise_variance` of a pixel, grey
/// levels^2.
/// `before`: a like picture, to fill from at first.
Picture noise_free(const Picture& picture, const Picture& known, double noise_variance,
                   const Picture* before = nullptr);

struct LearntGround {
  Ground ground;
  std::vector<std::optional<GroundFix>> fixes;  ///< of the frames learnt from
  Eigen::Matrix2d excess =
      Eigen::Matrix2d::Identity();  ///< mean of N^(-1/2) S N^(-1/2), see GroundRegistration
  double texture = 0;               ///< grey levels rms beyond the noise
  double score = 0;                 ///< their median
};

/// From frames whose `start` is good to a texture's width. `place` of the window; `noise_variance` of a
/// pixel, the least that is believed. Nothing where too few frames can be registered: the ground shows
/// nothing.
std::optional<LearntGround> learn_ground(const std::vector<GroundFrame>& frames, const Rect& place,
                                         double noise_variance, int most_rounds, int threads = 1);

struct GroundMotionOptions {
  double noise_variance = 1.0 / 12;  ///< of a pixel, grey levels^2: the least that is believed
  int threads = 1;                   ///< the result is the same for any number
  /// What lies over the ground in a frame: the part with its shadow, a lamp. Others that cross are trimmed.
  std::function<std::vector<Circle>(std::int64_t index)> hidden = [](std::int64_t) {
    return std::vector<Circle>{};
  };
};

/// Frames, pixels of each and rounds of the learning.
struct GroundEffort {
  int frames = 0;
  int pixels = 0;
  int rounds = 0;
};
/// To tell whether the ground moves: at the cost of some windows about the part.
inline constexpr GroundEffort kGroundGlance{12, 1 << 16, 2};
/// To follow it: frames whose noise adds less than a hundredth; pixels beyond which registering a frame would
/// take longer than reading it, while four times as many would halve the standard deviation; rounds that
/// mostly are not needed.
inline constexpr GroundEffort kGroundLearning{128, 1 << 18, 10};

struct GroundSample {
  Rect place;  ///< what is learnt of the ground
  std::vector<GroundFrame> frames;
};

/// Collects the sample: frames spread over first .. last, but not evenly (that could meet the same phase of a
/// vibration again and again), read whole, kept as far as they show it; fewer of large pictures.
class GroundSampler {
 public:
  GroundSampler(const Picture& first_picture, const std::vector<Circle>& hidden, std::int64_t first,
                std::int64_t last, const GroundEffort& effort, double noise_variance);
  bool wants(std::int64_t index) const;
  /// One that is wanted; in order. `hidden`: see GroundMotionOptions.
  void see(FrameSource& source, std::int64_t index, const std::vector<Circle>& hidden);
  const GroundSample& sample() const { return sample_; }

 private:
  GroundSample sample_;
  CoarseShift coarse_;
  std::vector<std::int64_t> indices_;
  Picture whole_;
};
GroundSample sample_ground(FrameSource& source, std::int64_t first, std::int64_t last,
                           const GroundEffort& effort, const GroundMotionOptions& options);

/// What frames spread over the recording say of the ground.
struct GroundVerdict {
  bool visible = false;  ///< it shows a texture that locates it in both directions
  bool moves = false;    ///< and it does so beyond what its noise explains
  double texture = 0;    ///< grey levels rms beyond the noise
  bool brushed = false;  ///< most of it tells one direction only
  double limit_px = 0;   ///< median standard deviation of the worse direction in a frame
  double motion_px = 0;  ///< rms displacement about its mean beyond the noise, per axis
  std::string reason;    ///< with its figure
};
GroundVerdict look_at_ground(const GroundSample& sample, double noise_variance);

struct GroundMotion {
  std::vector<std::optional<GroundFix>>
      frames;           ///< first .. last; nothing where the ground was not found again
  int learnt_from = 0;  ///< frames
  GroundVerdict verdict;
};

/// Learns, then measures every frame. No frames where the ground is not visible (verdict).
GroundMotion follow_ground(FrameSource& source, std::int64_t first, std::int64_t last,
                           const GroundMotionOptions& options);

}  // namespace tribotrack::vision
