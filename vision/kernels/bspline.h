// Quintic B-spline pictures: interpolation accurate enough that its error lies below the noise.
//
// s(x, y) = sum_jk c_jk b(x - j) b(y - k) with b the B-spline of degree 5; the coefficients c come from the
// picture by the recursive prefilter of Unser, Aldroubi, Eden, "B-spline signal processing", IEEE Trans.
// Signal Proc. 41 (1993), poles -0.430575 and -0.0430963, so that s passes through every pixel. Polynomials
// up to degree 5 are reproduced exactly away from the border (whole-sample mirror there).
#pragma once

#include <array>
#include <vector>

#include "vision/kernels/tile_kernels.h"
#include "vision/picture.h"

namespace tribotrack::vision {

/// Weights of the six coefficients around t, and their derivatives by t, along both axes.
SplineTaps spline_taps(double fraction_x, double fraction_y);

/// Value and gradient of a spline at one place.
struct SplineSample {
  double value = 0, slope_x = 0, slope_y = 0;
};

class QuinticSpline {
 public:
  QuinticSpline() = default;
  /// Coefficients are computed here, once.
  explicit QuinticSpline(const Picture& picture);

  int width() const { return width_; }
  int height() const { return height_; }

  /// Anywhere up to 5 px beyond the picture; further out the place is clamped.
  double value(double x, double y) const { return sample(x, y).value; }
  SplineSample sample(double x, double y) const;

  /// The same at many places at once, in single precision. Slopes may be null, both together. Places are
  /// clamped to 5 px before and 4 px beyond the picture.
  void sample_places(const std::vector<float>& x, const std::vector<float>& y, float* value, float* slope_x,
                     float* slope_y) const;

  /// The coefficient c_xy, for filters of their own; rows are `stride()` apart. Up to kPad px beyond the
  /// picture.
  const float* coefficient(int x, int y) const { return coefficient_row(y) + x; }
  std::ptrdiff_t stride() const { return stride_; }
  static constexpr int kPad = 16;

  /// A whole window at one fraction: out[j * width + i] = s(x0 + i, y0 + j). Every pixel has the same
  /// fraction, so this is a separable filter of six taps. slope_x and slope_y may be null. The window must
  /// lie within the picture grown by 5 px.
  void sample_window(double x0, double y0, int width, int height, float* value, float* slope_x,
                     float* slope_y) const;

  /// The same over tiles whose first pixels are `tiles` pixels from (x0, y0), which must lie within the
  /// picture grown by kPad - 3 px; values less `pivot`. `corners` is scratch of the tiles' number. Of all
  /// tiles or `tile` .. `end` - 1.
  void sample_tiles(double x0, double y0, const std::vector<TilePlace>& tiles,
                    std::vector<const float*>& corners, float pivot, bool slopes, TileArrays& arrays,
                    std::size_t tile = 0, std::size_t end = kAllTiles) const;

 private:
  const float* coefficient_row(int y) const {
    return coefficients_.data() + static_cast<std::size_t>(y + kPad) * stride_ + kPad;
  }
  int width_ = 0, height_ = 0, stride_ = 0;
  std::vector<float> coefficients_;  ///< padded by kPad on every side
};

/// White noise of unit variance interpolated at two fractions f and g of a pixel along one axis: covariance
/// of the two values, of the slope at f with the value at g, of the two slopes. The second is not zero:
/// interpolated noise is quieter between pixels than on them, and a registration that does not know this is
/// drawn there.
struct InterpolationNoise {
  double value = 1, slope_value = 0, slope = 0;
};
InterpolationNoise quintic_noise(double f, double g);
/// At one fraction: variances.
inline InterpolationNoise quintic_noise(double fraction) {
  return quintic_noise(fraction, fraction);
}

}  // namespace tribotrack::vision
