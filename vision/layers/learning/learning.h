// Learning the layers from kept windows: which disc, rim, ground, noise, and where in each window?
//
// Each sweep learns the pictures from the windows in their present states, then measures the windows over
// these pictures: alternating least squares, accelerated (anderson_acceleration.h) because a shift that goes
// with the disc's place on the platform is told from a ground under the rim only slowly.
#pragma once

#include <span>
#include <vector>

#include "vision/layers/registration/registration.h"

namespace tribotrack::vision {

class LayeredLearning {
 public:
  /// Keeps references. `radius` of the disc, `noise` a start;
  /// `least_noise` variance on the ground that the windows are taken to have whatever their residuals say.
  LayeredLearning(LayeredDisc& disc, GroundPicture& ground, LayeredRegistration& registration, double radius,
                  const NoiseLaw& noise, double least_noise = 0);

  /// From a few windows, until they hardly move any more, then from all. False where the layers do not
  /// explain most windows.
  bool run(std::span<KeptWindow> early, std::span<KeptWindow> all);

  const NoiseLaw& noise() const { return noise_; }
  /// Mean standard deviation of a coordinate of the windows, px.
  double sigma() const { return sigma_; }
  /// Of the averaged picture's rim from the pivot of its grid; radius 0 where it shows no circle.
  Point offset() const { return offset_; }
  double disc_radius() const { return disc_radius_; }
  double disc_radius_sd() const { return disc_radius_sd_; }
  /// The light's slope over the disc, which a frame then need not find out by itself.
  const IlluminationSlope& light() const { return light_; }
  /// Mean chi^2 per pixel of the rim.
  double rim_chi_squared() const { return rim_chi_squared_; }
  /// Of the positions measured over what has been learnt.
  const SlowError& slow_error() const { return slow_error_; }

 private:
  void learn(std::span<KeptWindow> windows, bool last);
  bool measure(std::span<KeptWindow> windows, std::vector<GroundLean>* leans = nullptr);
  void leave_out_odd(std::span<KeptWindow> windows, const std::vector<double>& rim_chi_squared) const;
  void centre_rim(std::span<KeptWindow> windows);

  LayeredDisc& disc_;
  GroundPicture& ground_;
  LayeredRegistration& registration_;
  double radius_;
  NoiseLaw noise_;
  IlluminationSlope light_;
  SlowError slow_error_;
  double start_noise_, least_noise_;
  int sweeps_ = 0, first_windows_ = 0;
  Point offset_;
  Eigen::Vector2d shift_ = Eigen::Vector2d::Zero();  ///< of the rim, from the last measure()
  double disc_radius_ = 0, disc_radius_sd_ = 0, rim_chi_squared_ = 0, sigma_ = 0;
};

}  // namespace tribotrack::vision
