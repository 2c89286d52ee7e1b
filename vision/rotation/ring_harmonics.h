// What turns with a disc, ring by ring: the Fourier coefficients of its levels along circles about its
// centre.
//
//   P_m(r) = (1 / N) sum_j I(c + r e(phi_j)) exp(-i m phi_j),   phi counter-clockwise with y up.
// A part turned by theta shows P_m exp(-i m theta): a rotation is a phase. Left out are the slow harmonics,
// which a lamp's reflection and an error of the centre have too, and those shorter than the pixels resolve.
#pragma once

#include <Eigen/Core>
#include <complex>
#include <vector>

#include "vision/picture.h"

namespace tribotrack::vision {

/// Real and imaginary parts; rows are the harmonics m = 0, 1, ..., columns the rings.
struct Harmonics {
  Eigen::ArrayXXf re, im;

  Eigen::Index orders() const { return re.rows(); }
  Eigen::Index rings() const { return re.cols(); }
  std::complex<double> operator()(Eigen::Index ring, Eigen::Index order) const {
    return {static_cast<double>(re(order, ring)), static_cast<double>(im(order, ring))};
  }
};

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
  std::vector<float> x_, y_, levels_, transformed_;
};

}  // namespace tribotrack::vision
