// Where exactly is the disc in a frame, both layers known?
//
// Weighted Gauss-Newton on  sum_x (I(x) - [a (1 + g . u) S(u; theta) + b w(u) B(x - p)])^2 / (n0 + n1 I)
// over c, theta, a, g and b, u = x - c. The gradient with respect to c is -(a (1 + g . u) grad S + b B grad
// w). Layers are quintic splines shifted against the untouched picture, whose noise stays white. The
// covariance of c is its block of the inverse of the Fisher information, the other unknowns being unknown.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "vision/layered_disc.h"

namespace tribotrack::vision {

/// What is known of the light's slope before a frame is looked at.
struct LightPrior {
  double slope_x = 0, slope_y = 0;
  double sd = 0;  ///< 0: nothing is known
};

struct LayeredFix {
  LayeredState state;
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  ///< of the centre, px^2
  double sigma_slope = 0;                                ///< of g, 1/px
  double chi_squared = 0;                                ///< per pixel, all that count
  double rim_chi_squared = 0;                            ///< per pixel of the rim
  double trimmed_share = 0;
  double ncc = 0;  ///< picture against model
};

class LayeredRegistration {
 public:
  /// Keeps references: disc and ground must outlive it.
  LayeredRegistration(const LayeredDisc& disc, const GroundPicture& ground);

  void set_noise(const NoiseLaw& noise) { noise_ = noise; }
  /// To be called when the disc has learnt something new.
  void disc_changed();

  /// `picture` is a window of the frame whose first pixel is pixel (x, y). nullopt where too little of the
  /// rim lies in the window over known ground, or where the fit does not converge within 2 px.
  std::optional<LayeredFix> refine(const Picture& picture, int x, int y, const LayeredState& start,
                                   const LightPrior& prior = {});

  /// Pixels about the centre that refine() looks at.
  int reach() const { return reach_; }

  /// Residuals of the last refine(), for the noise law: levels predicted and squared residuals of the pixels
  /// away from the rim are added up.
  struct LevelSums {
    double n = 0, level = 0, level_level = 0, square = 0, level_square = 0;
  };
  void add_residuals(LevelSums& sums) const;

 private:
  void turn_to(double theta);
  void form(const LayeredState& state, bool slopes);

  const LayeredDisc& disc_;
  const GroundPicture& ground_;
  NoiseLaw noise_;
  int reach_ = 0;
  double cached_theta_ = 1e9;
  QuinticSpline standing_, slope_theta_, share_;
  // The window: one entry per pixel.
  int x0_ = 0, y0_ = 0;
  std::vector<float> level_, weight_, below_, known_, disc_level_, disc_x_, disc_y_, disc_theta_,
      see_through_, see_x_, see_y_, residual_, predicted_, u_, v_, rho_;
  Eigen::MatrixXf jacobian_;
};

}  // namespace tribotrack::vision
