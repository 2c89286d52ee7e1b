// The brushed platform of a synthetic scene: a sum of plane waves, whose pixel means, shifts and motion blur
// are all known in closed form.
#pragma once

#include <Eigen/Core>
#include <complex>
#include <cstdint>
#include <span>
#include <vector>

#include "vision/synthesis/camera.h"

namespace tribotrack::vision {

/// B(x) = sum_w a cos(k_w . x + theta_w), k_w drawn from the spectrum of the covariance
///   texture_rms^2 exp(-u^2 / (2 length^2) - v^2 / (2 width^2)),  u along the brush, v across it,
/// stratified so that few waves represent it well. Its mean square over the plane is exactly texture_rms^2.
class PlatformTexture {
 public:
  struct Wave {
    double kx = 0, ky = 0;  ///< rad/px, y down
    double phase = 0;
    double amplitude = 0;
  };
  PlatformTexture(const PlatformAppearance& platform, std::uint64_t seed);

  const std::vector<Wave>& waves() const { return waves_; }
  /// The largest component of any wave vector, rad/px.
  double max_wave_number() const;

 private:
  std::vector<Wave> waves_;
};

/// The texture on a grid of places xs x ys. A wave factors into x and y, so the grid is a product of two thin
/// matrices, and a displacement or its mean over an exposure changes only one coefficient per wave.
class TextureGrid {
 public:
  using Coefficients = std::vector<std::complex<double>>;
  enum class Value { kAtPoint, kPixelMean };

  TextureGrid(const PlatformTexture& texture, std::span<const double> xs, std::span<const double> ys,
              Value value);

  /// For the mean over an exposure.
  Coefficients coefficients(std::span<const ExposureNode> nodes) const;
  /// The whole grid, added to the picture of the same size.
  void add_to(Picture& picture, const Coefficients& coefficients) const;
  /// One row of it: prepare once, then evaluate its places.
  void prepare_row(const Coefficients& coefficients, int iy, Eigen::VectorXf& row) const;
  float at(const Eigen::VectorXf& row, int ix) const { return row.dot(columns_.col(ix)); }
  bool empty() const { return waves_.empty(); }

 private:
  std::vector<PlatformTexture::Wave> waves_;  // amplitudes times the pixel's own blur
  Eigen::MatrixXf columns_;                   // cos(kx x) over sin(kx x): 2 waves x places
  Eigen::MatrixXcd rows_;                     // exp(i ky y): waves x places
};

}  // namespace tribotrack::vision
