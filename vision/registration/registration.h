// Sub-pixel registration: where exactly does the template lie in a picture?
//
// Minimises the ZNCC criterion, i.e. sum_x w(x) (I(x) - a T(R(theta)^T (x - c - d)) - b)^2 over the
// displacement d, the gain a, the offset b and, where the template has a texture that shows it, the rotation
// theta, by Gauss-Newton. It is inverse compositional in the sense of Baker & Matthews (IJCV 56, 2004): the
// template moves, the picture stays untouched (its noise stays white, it needs no prefilter), and the
// derivatives and their normal matrix are those of the template, formed once per picture and kept for all
// iterations. T is a quintic B-spline whose coefficients are computed once.
//
// Only informative pixels take part (informative_pixels()): of a plain disc a ring about its rim.
//
// The template's own noise, interpolated, is quieter between pixels than on them, which draws d towards half
// pixels by an amount proportional to its variance; that known force is taken out of the normal equations.
//
// Covariance of d (Cramer-Rao): sigma^2 (sum w J^T J)^-1, corrected for the noise that the derivatives of a
// noisy template carry; where the residual exceeds the noise the excess is added by a sandwich estimate over
// 8 x 8 px tiles, which allows for its correlation.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "vision/audit/halves.h"
#include "vision/kernels/bspline.h"
#include "vision/kernels/dense.h"
#include "vision/kernels/tile_kernels.h"
#include "vision/picture.h"
#include "vision/registration/pattern.h"

namespace tribotrack::vision {

/// Displacement of the template from its place in the first frame, px, and its rotation, rad,
/// counter-clockwise as seen (y up).
struct Pose {
  double dx = 0, dy = 0, theta = 0;
};

struct Registration {
  bool converged = false;
  Pose pose;
  double gain = 1, offset = 0;
  double ncc = 0;           ///< zero-mean normalised cross-correlation under the whole mask
  double residual_rms = 0;  ///< grey levels
  double excess_rms = 0;    ///< part of it beyond the noise of picture and template
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  ///< of (dx, dy), px^2
  double sigma_theta = 0;                                ///< rad; 0 where rotation is not estimated
};

struct RegistrationOptions {
  double noise_variance = 1.0 / 12;  ///< of the picture, grey levels^2
  double template_noise_share = 1;   ///< of it in the template: 1/M for one averaged over M frames
  bool rotation = false;
};

/// Defined in two files: registration.cpp (the iteration, trimming and the sandwich covariance, the sums of
/// each tile for the audit), template.cpp (set-up; levels and slopes of the template at a pose, the picture
/// under it, the template's own noise in the normal equations).
class TemplateRegistration {
 public:
  /// Copies what it needs of the first frame.
  TemplateRegistration(const Picture& first, const Pattern& pattern, const RegistrationOptions& options);

  /// Refines a pose. `picture` is a window of the frame whose first pixel is pixel (x, y) of the frame.
  /// Template pixels that fall outside the window are left out.
  Registration refine(const Picture& picture, int x, int y, const Pose& start);

  /// After a refine() that converged: what the disagreement of two halves says of the pose found.
  std::optional<HalvesError> halves() const;

  /// ZNCC at a pose, nothing refined.
  double score(const Picture& picture, int x, int y, const Pose& pose);

  /// Template grey levels at a pose, on a window of the camera.
  Picture at(const Pose& pose, const Rect& window) const;
  /// Cramer-Rao bound of (dx, dy) for the template itself, px^2.
  Eigen::Matrix2d limit() const { return limit_; }
  const Pattern& pattern() const { return pattern_; }
  double contrast() const { return contrast_; }
  double area() const { return area_; }
  /// What the template's own noise adds to the variance of the position, relative to the bound.
  double template_noise_cost() const { return template_noise_cost_; }

 private:
  using Matrix = FewByFew;
  using Vector = Few;
  void choose_pixels();
  void sample_template(const Pose& fraction, bool slopes);
  void sample_turned(const Pose& fraction, bool slopes);
  bool take_picture(const Picture& picture, int x, int y, int whole_x, int whole_y);
  Matrix normal_matrix() const;
  std::vector<TileSums> tile_sums() const;
  Matrix debiased(const Matrix& normal, const Pose& fraction) const;
  double residual_noise(const ForceSums& sums, const Pose& at, double gain) const;
  Eigen::Vector2d noise_force(const ForceSums& sums, const Pose& formed, const Pose& at, double gain) const;
  std::size_t trim(const ForceSums& sums, double gain, double offset, double noise_sd);
  Eigen::Matrix3d sandwich(const Matrix& inverse, double gain, double offset);
  double template_noise() const { return options_.template_noise_share * options_.noise_variance; }
  int columns() const { return options_.rotation ? 5 : 4; }

  RegistrationOptions options_;
  Pattern pattern_;
  QuinticSpline spline_;
  int spline_x_ = 0, spline_y_ = 0;  ///< first pixel of the spline in the first frame
  float pivot_ = 0;                  ///< mean level of the template
  double contrast_ = 0;              ///< its standard deviation
  double area_ = 0;                  ///< pixels of the mask
  double pixels_ = 0;                ///< number of pixels that take part
  double template_noise_cost_ = 0;
  Eigen::Matrix2d limit_ = Eigen::Matrix2d::Zero();

  std::vector<TilePlace> places_;  ///< in the window
  std::vector<float> mask_;        ///< weights of the tiles' pixels, those beyond the window 0
  /// The last pose refined.
  struct Found {
    double gain = 1, offset = 0;  ///< as in the kernels: of levels less the pivot
    double noise = 0;             ///< variance of a residual
    Eigen::Vector2d noise_force = Eigen::Vector2d::Zero();
    Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  ///< by the model, without what the residual adds
  };
  Found found_;

  // Work space.
  TileArrays arrays_;
  std::vector<float> base_weight_;          ///< before trimming
  std::vector<float> turned_x_, turned_y_;  ///< scratch of sample_turned
  std::vector<const float*> corners_;
};

}  // namespace tribotrack::vision
