// Learning the light that stands in the picture from kept windows whose layers are known.
//
// With M_t what the layers say of frame t, L = 1 + sum_k l_k phi_k and H = sum_k h_k phi_k on cubic
// B-splines,
//   I_t(x) - M_t(x) = sum_k (l_k M_t(x) + h_k) phi_k(x) + L(x) J_t(x) d_t + noise,
// d_t the frame's own unknowns (place, light, rotation), which are eliminated frame by frame: a slope of the
// light that a frame's own light could have made is not looked for, and what is found owes nothing to the
// places, which it has moved until now [Golub and Pereyra, SIAM J. Numer. Anal. 10 (1973) 413]. Layers and
// light are learnt in turn. A place seen too seldom is held to 0 by a wide prior, and what is not known of
// the light goes into the frames' covariances.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "vision/layers/model/disc.h"
#include "vision/layers/model/static_illumination.h"

namespace tribotrack::vision {

class LightLearning {
 public:
  /// `windows` hold pictures from which `light` is taken out. Ground at rest shows the light together with
  /// its own picture, whatever the light is made of. Ground that moves does not: its picture, which may hold
  /// the light by mistake, is left out of account, and what counts is that it is as bright everywhere but for
  /// a texture that `frames_of_moving_ground` windows see alike (0: it rests).
  LightLearning(const LayeredDisc& disc, const GroundPicture& ground, const NoiseLaw& noise,
                const StaticIllumination& light, bool first, double frames_of_moving_ground);
  void add(const KeptWindow& window);

  struct Learnt {
    StaticIllumination light;
    /// Of the places of the windows, in their order, px^2: what is not known of the light.
    std::vector<Eigen::Matrix2d> covariance;
  };
  Learnt solve();

 private:
  struct Lean {
    std::vector<int> nodes;
    Eigen::Matrix<double, 2, Eigen::Dynamic> of;  ///< -dc / d(l, h)
  };
  void add_prior(double level);
  void draw(const Eigen::VectorXd& coefficients, StaticIllumination& light) const;
  void hide(StaticIllumination& light) const;
  double weight_at(int column, int k) const { return weights_[static_cast<std::size_t>(4 * column + k)]; }

  const LayeredDisc& disc_;
  const GroundPicture& ground_;
  NoiseLaw noise_;
  const StaticIllumination& light_;
  double cut_;
  bool ground_moves_;
  double texture_variance_;  ///< of moving ground about its mean, as often as it is seen
  QuinticSpline share_, standing_;
  double spacing_ = 8;
  int across_ = 0, down_ = 0;    ///< nodes
  std::vector<double> weights_;  ///< of the four nodes about a pixel, by its distance from the first
  std::vector<int> first_;       ///< of these nodes
  Eigen::MatrixXd normal_;       ///< all l, then all h
  Eigen::VectorXd right_;
  std::vector<Lean> leans_;
  Picture seen_, strange_;  ///< times a pixel showed the disc, and times it showed something else
};

}  // namespace tribotrack::vision
