// Where exactly is the disc in a frame, both layers known?
//
// Weighted Gauss-Newton on  sum_x (I(x) - [a (1 + g . u) S(u; theta) + b G(x)])^2 / var(x),
//   G = w(u) B(x - p) + kappa grad w . grad B,   var = n0 + n1 I + (b w)^2 var_B,
// over c, theta, a, g and b, u = x - c. The gradient with respect to c is -(a (1 + g . u) grad S + b B grad
// w). Layers are quintic splines shifted against the untouched picture, whose noise stays white; var_B is
// what is not known of the ground, which at places never uncovered is its whole texture. The covariance of c
// is its block of the inverse of the Fisher information, the other unknowns being unknown.
//
// Only pixels that tell something about c take part one by one, in tiles of 8 x 8 (informative_pixels.h). The
// disc's even middle tells about the light alone: it is summed against the disc's picture at whole pixels.
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <limits>
#include <optional>
#include <vector>

#include "vision/kernels/informative_pixels.h"
#include "vision/layers/model/disc.h"
#include "vision/layers/model/illumination_slope.h"
#include "vision/layers/model/static_illumination.h"
#include "vision/layers/registration/kernels.h"
#include "vision/layers/registration/slow_error.h"

namespace tribotrack::vision {

struct LayeredFix {
  LayeredState state;
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  ///< of the centre, px^2
  double sigma_slope = 0;                                ///< of g, 1/px
  double rim_chi_squared = 0;                            ///< per pixel of the rim
  double ncc = 0;                                        ///< picture against model, where it tells something
};

class LayeredRegistration {
 public:
  /// Keeps references: disc and ground must outlive it. The kernels are the fastest, unless a test compares.
  LayeredRegistration(const LayeredDisc& disc, const GroundPicture& ground,
                      const LayerKernels& layers = layer_kernels(),
                      const TileKernels& tiles = tile_kernels());

  void set_noise(const NoiseLaw& noise);
  /// Once the layers are learnt, rim_chi_squared of the usual frame: one far above holds something that
  /// neither layer has, and how far that may have drawn the disc goes into its covariance
  /// (cluster_sandwich.cpp).
  void set_usual(double rim_chi_squared) { usual_ = rim_chi_squared; }
  /// Light that is taken out of the pictures handed in: levels there are 1 / L as sure, and unseen ones do
  /// not count. Keeps the pointer; null without.
  void set_illumination(const StaticIllumination* light) { out_of_picture_ = light; }
  /// Pixels of the rim that tell something.
  double rim_pixels() const { return std::max(1.0, rim_pixels_); }
  bool has_illumination() const { return out_of_picture_ != nullptr; }
  /// To be called when the disc has learnt something new. `frames` it has learnt from: the noise of its
  /// picture is not information.
  void disc_changed(int frames);

  /// `picture` is a window of the frame whose first pixel is pixel (x, y). nullopt where too little of the
  /// rim lies in the window over known ground, or where the fit does not converge within 2 px.
  std::optional<LayeredFix> refine(const Picture& picture, int x, int y, const LayeredState& start,
                                   const LightPrior& prior = {});

  /// Which pixels of the disc's grid take part one by one: 1, else 0.
  const Picture& chosen() const { return chosen_; }
  /// Pixels about the centre that refine() looks at.
  int reach() const { return reach_; }

  /// Residuals of the last refine(), for the noise law: levels predicted and squared residuals of the pixels
  /// away from the rim are added up.
  struct LevelSums {
    double n = 0, level = 0, level_level = 0, square = 0, level_square = 0;
  };
  void add_residuals(LevelSums& sums) const;

  /// The last refine() on kappa: sums of weight q r and weight q^2 over the rim, q = b grad w . grad B; and
  /// on a shift of w alone, all else following: normal equations with q = -b (B - mean B) grad w, the frame's
  /// own unknowns eliminated.
  struct RimSums {
    double qr = 0, qq = 0;
    Eigen::Matrix2d shift_normal = Eigen::Matrix2d::Zero();
    Eigen::Vector2d shift_force = Eigen::Vector2d::Zero();
  };
  void add_rim(RimSums& sums) const;

  /// The last refine(): what of the ground the position leans on.
  GroundLean lean(const LayeredFix& fix) const;

 private:
  using Matrix =
      Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kLayerColumns, kLayerColumns>;
  using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, kLayerColumns, 1>;
  static constexpr double kTrim = 5;  ///< sd: a pixel further off is something else (dust, glare, a lamp)

  /// Light over the disc's even middle: sums against its three columns S (1, u, v). The middle is even but
  /// not flat: half a pixel down a highlight's slope looks like a lamp from the side. So the sums hold grad
  /// S, too, for a centre `shift` px off its pixel.
  struct Plateau {
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Vector3d force = Eigen::Vector3d::Zero();  ///< at light (1, 0, 0), shift 0
    /// Where the middle is not even (a highlight, defocus): its slope against the light and itself, and the
    /// frame's residuals against it.
    Eigen::Matrix<double, 3, 2> slope = Eigen::Matrix<double, 3, 2>::Zero();
    Eigen::Matrix2d steepness = Eigen::Matrix2d::Zero();
    Eigen::Vector2d pull = Eigen::Vector2d::Zero();
    double squares = 0, pixels = 0;
    void add(double weight, const Eigen::Vector3d& column, const Eigen::Vector2d& gradient);
    Eigen::Vector3d force_at(const LayerLight& light, const Eigen::Vector2d& shift) const;
    Eigen::Vector2d step_force_at(const LayerLight& light, const Eigen::Vector2d& shift) const;
    double squares_at(const LayerLight& light, const Eigen::Vector2d& shift) const;
  };
  void choose_pixels(int frames);
  void make_plateau();
  void turn_to(double theta);
  bool take_picture(const Picture& picture, int x, int y, const Point& ground);
  Plateau take_plateau(const Picture& picture, int x, int y) const;
  Plateau trimmed_plateau(const Picture& picture, int x, int y, const LayerLight& light,
                          const Eigen::Vector2d& shift, double trim) const;
  float precision(int column, int row) const;
  void leave_unseen(std::size_t tile);
  void slope_of_middle();
  Eigen::Vector2d shown_slope(int i, int j) const;
  void sample(const Point& centre, bool slopes);
  Matrix normal_matrix(const LayerLight& light, const Plateau& plateau, double hold);
  std::size_t trim(const LayerLight& light);
  Eigen::Matrix2d scattered(const Matrix& inverse) const;
  float residual(std::size_t i, const LayerLight& light) const;
  int columns() const { return disc_.turning() ? 7 : 6; }

  const LayeredDisc& disc_;
  const GroundPicture& ground_;
  LayerKernels layer_kernels_;
  TileKernels tile_kernels_;
  NoiseLaw noise_;
  const StaticIllumination* out_of_picture_ = nullptr;
  double usual_ = std::numeric_limits<double>::infinity();
  int reach_ = 0;
  double cached_theta_ = 1e9;
  Picture shown_;  ///< S at the angle it was last formed for
  QuinticSpline standing_, slope_theta_, share_;

  std::vector<TilePlace> places_;  ///< px from the centre's pixel
  Picture chosen_;
  std::vector<float> mask_;  ///< 1 where a pixel of a tile counts
  double rim_pixels_ = 0, rim_counted_ = 0;
  Picture plateau_weight_;     ///< on the disc's grid
  Plateau plateau_;            ///< all but the frame's own sums
  Picture slope_x_, slope_y_;  ///< of the disc's picture where plateau_weight_ counts; empty where it is even
  int frames_ = 1;             ///< the disc has learnt from
  struct Run {
    int y = 0, first = 0, count = 0;  ///< on the disc's grid
  };
  std::vector<Run> runs_;
  std::vector<float> ramp_;  ///< -half .. half

  // The frame at hand.
  int x0_ = 0, y0_ = 0;  ///< the centre's pixel
  LayerArrays arrays_;
  std::vector<float> counts_;  ///< mask_ less what lies outside the picture or is trimmed
  std::vector<const float*> corners_;
  LayerLight light_;  ///< of the last refine()
  Matrix normal_;     ///< likewise
};

}  // namespace tribotrack::vision
