// The rotation of a disc through a recording, its centre known in every frame, with its standard deviation.
#pragma once

#include <Eigen/Core>
#include <complex>
#include <cstdint>
#include <optional>
#include <vector>

#include "vision/frame_source.h"
#include "vision/picture.h"
#include "vision/stages/stages.h"
#include "vision/track.h"

namespace tribotrack::vision {

/// One per frame, 0 in the first; nothing where the disc's inside does not look like before. Empty where that
/// holds for most frames, or no rotation can be seen.
///
/// The variance is that of the harmonics' scatter, and what grows with the angle turned as the learnt picture
/// is renewed: from how the angles by the inner and the outer rings, each learnt for itself, drift apart. The
/// same for any number of threads.
std::vector<std::optional<Rotation>> follow_rotation(FrameSource& source, const SeenFrames& frames,
                                                     double radius, double blur, int threads = 1);

// The rotation of the part in every frame in which it was found, where its texture shows it.

/// Fills the points' rotation: of a disc by its rings about the centres of the track, of a
/// rectangle as its template was registered. A disc's template is not asked: under a lamp that stands still
/// it sees a turning disc turn less, and says it knows. Nothing where the first frame shows no texture.
/// `plan` is told of the rings.
void measure_rotation(FrameSource& source, const FirstPassResult& first, Track& track,
                      std::vector<PlanStage>& plan, int threads = 1);

// What turns with a disc, ring by ring: the Fourier coefficients of its levels along circles about its
// centre.
//
//   P_m(r) = (1 / N) sum_j I(c + r e(phi_j)) exp(-i m phi_j),   phi counter-clockwise with y up.
// A part turned by theta shows P_m exp(-i m theta): a rotation is a phase. Left out are the slow harmonics,
// which a lamp's reflection and an error of the centre have too, and those shorter than the pixels resolve.

/// Rows are the harmonics m = 0, 1, ..., columns the rings.
using Harmonics = Eigen::ArrayXXcf;

class RingHarmonics {
 public:
  /// Of a disc whose rim has the Gaussian blur `blur`, px: rings end where the rim begins.
  RingHarmonics(double radius, double blur);

  /// Whether the disc is large enough to have rings at all.
  bool usable() const { return weights_.size() > 0; }
  /// Px about the centre that of() looks at.
  double reach() const;
  /// `window` is a part of the frame, the disc's centre at `centre` in it.
  Harmonics of(const Picture& window, const Point& centre);
  /// Pixels that are averaged before.
  int averaged() const { return reduction_ * reduction_; }
  /// Pixels that a coefficient stands for, 0 for those left out; rows and columns as in Harmonics.
  const Eigen::ArrayXXf& weights() const { return weights_; }

 private:
  int reduction_ = 1;  ///< a large disc is averaged over reduction x reduction pixels
  int angles_ = 0;
  double radius_ = 0;
  Eigen::ArrayXd rings_;  ///< radii, in reduced pixels
  Eigen::ArrayXXf weights_;
  std::vector<float> offset_x_, offset_y_;  ///< of all places from the centre, ring after ring
  // Work space.
  Picture reduced_;
  std::vector<float> x_, y_, levels_;
};

/// Cramer-Rao bound of the rotation from one frame, rad; 1e9 where no texture stands out of the noise. A
/// coefficient that stands for w pixels has the noise sigma^2 / (2 pi w), so the harmonics tell
///   sum m^2 |P|^2 4 pi w / sigma^2
/// of the angle, less the 2 m^2 each that noise alone makes of it.
double rotation_limit(const Picture& frame, const Circle& part, double blur, double noise_variance);

// How far a disc has turned since the first frame, from the harmonics of its rings.
//
// A turning mean T is learnt on the way: in each frame theta maximises the correlation
//   C(theta) = Re sum_m exp(i m theta) sum_r w conj(T_m(r)) P_m(r),
// by Newton from the predicted angle, from the best of all angles where that does not do; then the frame,
// turned back, joins the mean. The mean forgets with the angle turned, since metal under a lamp looks
// different from every side; of a part that does not turn it is the mean of all frames, without drift.

struct Turn {
  double theta = 0;        ///< rad, counter-clockwise as seen (y up); not wrapped
  double information = 0;  ///< curvature of the criterion
  double scatter = 0;      ///< sum of the squared pulls of the harmonics: variance of the criterion's slope
};

/// Of the mean T and a picture P over all rings, for each harmonic: sum w conj(T) P, sum w |T|^2, sum w
/// |P|^2. P turned back has the same but for a phase.
struct RingSums {
  Eigen::ArrayXcd correlation;
  Eigen::ArrayXd of_mean, of_seen;
};

class RotationFollower {
 public:
  RotationFollower(const Harmonics& first, const Eigen::ArrayXXf& weights, std::int64_t frame);

  /// Frames must come in order. Nothing where the part does not look like what was seen so far.
  std::optional<Turn> step(const Harmonics& seen, std::int64_t frame);
  /// Of the first frame, which has turned by nothing.
  double information() const;

 private:
  double predicted(std::int64_t frame) const { return theta_ + rate_ * static_cast<double>(frame - frame_); }
  double climb(const Eigen::ArrayXcd& correlation, double theta) const;
  double best_angle(const Eigen::ArrayXcd& correlation, double near) const;
  double correlation_at(const RingSums& sums, double theta) const;
  Turn judged(const RingSums& sums, double theta) const;
  void learn(const Harmonics& seen, double theta, std::int64_t frame);

  Eigen::ArrayXXf weights_;
  Eigen::ArrayXd orders_;  ///< m
  Harmonics mean_;
  double chance_ = 0;  ///< correlation that noise reaches
  double usual_ = 1;   ///< correlation of the recent frames
  double share_ = 1;   ///< of the newest frame in the mean
  double theta_ = 0, rate_ = 0;
  std::int64_t frame_ = 0;
};

}  // namespace tribotrack::vision
