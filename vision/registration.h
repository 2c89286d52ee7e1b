// Sub-pixel registration: where exactly does the template lie in a picture?
//
// Minimises the ZNCC criterion, i.e. sum_x w(x) (I(x) - a T(R(theta)^T (x - c - d)) - b)^2 over the
// displacement d, the gain a, the offset b and, where the template has a texture that shows it, the rotation
// theta, by Gauss-Newton. It is inverse compositional in the sense of Baker & Matthews (IJCV 56, 2004): the
// template moves, the picture stays untouched (its noise stays white, it needs no prefilter), and the
// derivatives and their normal matrix are those of the template, formed once per picture and kept for all
// iterations. T is a quintic B-spline whose coefficients are computed once.
//
// The template's own noise, interpolated, is quieter between pixels than on them, which draws d towards half
// pixels by an amount proportional to its variance; that known force is taken out of the normal equations.
//
// Covariance of d (Cramer-Rao): sigma^2 (sum w J^T J)^-1, corrected for the noise that the derivatives of a
// noisy template carry; where the residual exceeds the noise the excess is added by a sandwich estimate over
// 8 x 8 px blocks, which allows for its correlation.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "vision/bspline.h"
#include "vision/pattern.h"
#include "vision/picture.h"

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
  double ncc = 0;            ///< zero-mean normalised cross-correlation under the whole mask
  double residual_rms = 0;   ///< grey levels
  double excess_rms = 0;     ///< part of it beyond the noise of picture and template
  double trimmed_share = 0;  ///< pixels left out as not belonging to the template (glare, a hand)
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  ///< of (dx, dy), px^2
  double sigma_theta = 0;                                ///< rad; 0 where rotation is not estimated
  int iterations = 0;
};

struct RegistrationOptions {
  double noise_variance = 1.0 / 12;  ///< of the picture and of the template, grey levels^2
  bool rotation = false;
  int max_iterations = 20;
  double max_step_px = 4;  ///< further from the start than this is no convergence
  double tolerance_px = 1e-4;
};

class TemplateRegistration {
 public:
  /// Copies what it needs of the first frame.
  TemplateRegistration(const Picture& first, const Pattern& pattern, const RegistrationOptions& options);

  /// Refines a pose. `picture` is a window of the frame whose first pixel is pixel (x, y) of the frame.
  /// Template pixels that fall outside the window are left out.
  Registration refine(const Picture& picture, int x, int y, const Pose& start);

  /// ZNCC at a pose, nothing refined.
  double score(const Picture& picture, int x, int y, const Pose& pose);

  /// Template grey levels turned by theta about the pattern's centre, on the pattern's own window.
  Picture turned(double theta) const;

  /// Cramer-Rao bound of (dx, dy) for the template itself, px^2.
  Eigen::Matrix2d limit() const { return limit_; }
  /// Same for the rotation alone, from the pixels inside the rim, rad; 1e9 where no texture stands
  /// out of the noise.
  double limit_theta() const { return limit_theta_; }
  const Pattern& pattern() const { return pattern_; }
  const RegistrationOptions& options() const { return options_; }
  void set_rotation(bool on) { options_.rotation = on; }

 private:
  using Columns = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic>;
  void sample_template(const Pose& fraction, bool slopes);
  float turned_weight(int x, int y, double c, double s) const;
  bool take_picture(const Picture& picture, int x, int y, int whole_x, int whole_y, double theta);
  Eigen::MatrixXd normal_matrix() const;
  Eigen::MatrixXd debiased(const Eigen::MatrixXd& normal, const Pose& fraction) const;
  double residual_noise(const Pose& at, double gain) const;
  Eigen::Vector2d noise_force(const Pose& formed, const Pose& at, double gain) const;
  double correlation(const std::vector<float>& weights) const;
  std::size_t trim(double gain, double noise_sd);

  RegistrationOptions options_;
  Pattern pattern_;
  Picture levels_;  ///< of the window
  QuinticSpline spline_;
  int spline_x_ = 0, spline_y_ = 0;  ///< first pixel of the spline in the first frame
  float pivot_ = 0;                  ///< mean level of the template
  double contrast_ = 0;              ///< its standard deviation
  bool gaps_ = false;                ///< the mask has holes that turn with the template
  double pixels_ = 0;                ///< number of pixels that count
  Eigen::Matrix2d limit_ = Eigen::Matrix2d::Zero();
  double limit_theta_ = 0;
  std::vector<InterpolationNoise> noise_gain_;  ///< at fractions k / 16

  // Work space, one entry per pixel of the window.
  std::vector<float> level_, base_weight_, weight_, value_, slope_x_, slope_y_, slope_theta_, residual_;
  Columns jacobian_;
};

}  // namespace tribotrack::vision
