// What turns with a disc, ring by ring: the Fourier coefficients of its levels along circles about its
// centre.
//
//   P_m(r) = (1 / N) sum_j I(c + r e(phi_j)) exp(-i m phi_j),   phi counter-clockwise with y up.
// A part turned by theta shows P_m exp(-i m theta): a rotation is a phase. Left out are the slow harmonics,
// which a lamp's reflection and an error of the centre have too, and those shorter than the pixels resolve.
#pragma once

#include <Eigen/Core>
#include <complex>
#include <cstdint>
#include <optional>
#include <vector>

#include "vision/picture.h"

namespace tribotrack::vision {

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
  double predicted(std::int64_t frame) const;
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
