// Where exactly is the part in a frame, its pictures and the ground known?
//
// Weighted Gauss-Newton on  sum_x (I(x) - M(x))^2 / (V(u) + (b alpha)^2 var G),  M as in model.h, over c, a,
// s and b. The gradient with respect to c is
// -(a (1 + s . u) grad (F - alpha mean G) + b G grad alpha). Pictures are quintic splines shifted against the
// untouched frame, whose noise stays white. Only pixels that tell something about c take part, in tiles of
// 8 x 8 (informative_pixels()).
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "vision/audit/halves.h"
#include "vision/layers/model/model.h"
#include "vision/layers/registration/kernels.h"

namespace tribotrack::vision {

struct LayeredFix {
  LayeredState state;
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  ///< of the centre by the weights, px^2
  double slope_variance = 0;                             ///< of s as the frame alone tells it, 1/px^2
  double chi_squared = 0;                                ///< per pixel: weighted residual
  double ncc = 0;                                        ///< frame against model, where it tells something
};

/// What each cluster of a frame's pixels does to its position, i_c = N^-1 s_c with s_c the sum of w J r over
/// it, px. The position's error is their sum; where clusters err independently its covariance is the sum over
/// them of i_c i_c^T [Liang and Zeger, Biometrika 73 (1986) 13], whatever the weights are.
using ClusterPulls = std::vector<Eigen::Vector2f>;

class LayeredRegistration {
 public:
  /// Keeps a reference.
  explicit LayeredRegistration(const GroundPicture& ground) : ground_(ground) {}

  /// Pictures learnt from so many frames: their noise is not information.
  void set_part(const PartPictures& part, double frames);

  /// `picture` is a window of the frame whose first pixel is pixel (x, y). nullopt where too little of the
  /// part lies in the window or something else covers it, or where the fit does not converge within 2 px.
  std::optional<LayeredFix> refine(const Picture& picture, int x, int y, const LayeredState& start,
                                   const LightPrior& prior);

  /// Of the last refine(): what the residuals of each cluster of tiles did to the position. A cluster holds
  /// the tiles of one sector and of that opposite: what is even about the centre (defocus, a change of size)
  /// moves both against each other and the position not at all.
  ClusterPulls cluster_pulls();
  /// Share of a cluster's squares that the position took, along x and y: sum_c (N^-1 N_c)^2.
  Eigen::Array2d share_taken() const { return share_taken_; }
  /// Of the last refine(): what the disagreement of two halves says of the position. A change of size or
  /// blur, which moves opposite edges against each other and the position not at all, is taken out first.
  std::optional<HalvesError> halves() const;

  /// Pixels about the centre that refine() looks at.
  int reach() const { return half_ + 1; }

 private:
  using Matrix = TileSums::Matrix;
  using Vector = TileSums::Vector;
  void choose_pixels(const PartPictures& part, double frames);
  void make_clusters(const std::vector<Eigen::Matrix2d>& information);
  bool take_picture(const Picture& picture, int x, int y, const Point& ground);
  void take_variance(const Point& centre);
  void sample(const Point& centre, bool slopes);
  Matrix normal_matrix(const LightPrior& prior);
  std::size_t trim();
  float residual(std::size_t i) const;
  std::vector<TileSums> tile_sums() const;

  const GroundPicture& ground_;
  int half_ = 0;
  QuinticSpline level_, share_;  ///< F and alpha
  Picture variance_;

  std::vector<TilePlace> places_;  ///< px from the centre's pixel
  std::vector<float> mask_;        ///< 1 where a pixel of a tile counts
  double pixels_ = 0;
  Eigen::Array2d share_taken_ = Eigen::Array2d::Zero();
  std::vector<std::size_t> cluster_;  ///< of each tile
  std::size_t clusters_ = 0;

  // The frame at hand.
  int x0_ = 0, y0_ = 0;  ///< the centre's pixel
  LayerArrays arrays_;
  std::vector<float> counts_;  ///< mask_ less what lies outside the picture or is trimmed
  std::vector<const float*> corners_;
  LayerLight light_;
  Matrix normal_;
};

}  // namespace tribotrack::vision
