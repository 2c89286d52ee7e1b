// What levels do along a ray across the rim, as a Gaussian process with a hard edge in it.
//
// Levels along a ray are blur * fields: of the top, which ends where the chamfer begins; of the whole part,
// which ends at the edge; of what lies outside, which begins there; of the chamfer, one level; and fine
// texture of the top. Each is a Gaussian process of given correlation length along the ray [Rasmussen,
// Williams, Gaussian Processes for Machine Learning (2006)], so that
//   cov(s, t) = sum_q v_q Q_q(s, t),   Q_q = E m_q K_q m_q E^T,
// with E the blur, m_q the field's mask and K_q its correlation. That fields end at the edge is all that ties
// the centre down: a level that changes inside an edge does not look like an edge that moves, and Q says by
// how much. The variances v_q >= 0 are those of greatest likelihood for sample covariances C of rays,
//   v_q <- v_q sqrt(tr(X Q_q) / tr(S^-1 Q_q)),  X = S^-1 C S^-1,  S = N + sum v_q Q_q  [multiplicative
//   updates: Zhou, Hu,
// Zhou, Lange, "MM algorithms for variance components models", J. Comput. Graph. Stat. 28 (2019)].
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "vision/frame_source.h"
#include "vision/kernels/bspline.h"

namespace tribotrack::vision {

// Frames sampled along rays about the part's centre: place s of ray p lies at radius + s - inside px from the
// centre, in the direction 2 pi p / azimuths.

struct RayGrid {
  double radius = 0;            ///< px, about
  int inside = 7, outside = 4;  ///< px of it that are looked at
  int azimuths = 0;             ///< rays, about one a pixel of the rim
  std::size_t places() const { return static_cast<std::size_t>(inside + outside + 1); }
  std::size_t size() const { return places() * static_cast<std::size_t>(azimuths); }
  /// Of a place from the nominal rim, px.
  double offset(std::size_t place) const { return static_cast<double>(place) - inside; }
  double reach() const { return radius + outside; }
};

RayGrid ray_grid(double radius);

/// Levels ray by ray, RayGrid::size() of them; slopes, if wanted, in grey levels per px along x and y.
struct RayLevels {
  float* level = nullptr;
  float *slope_x = nullptr, *slope_y = nullptr;
};

class RaySampler {
 public:
  explicit RaySampler(const RayGrid& grid);
  /// The window that a sample about `centre` is taken from; not all of it need lie in the picture.
  Rect window(const Point& centre) const;
  /// From the spline of that window.
  void sample(const QuinticSpline& spline, const Rect& window, const Point& centre, const RayLevels& out);

 private:
  RayGrid grid_;
  std::vector<float> along_x_, along_y_, x_, y_;  ///< px from the centre, and in the window
};

/// Of the rim: where the edge is beyond the grid's radius, how wide the lens smears it, how wide its chamfer
/// is, px.
struct RimOptics {
  double edge = 0, blur = 0.85, chamfer = 0.5;
};

class RayFields {
 public:
  /// Fields are constant in cells of so many px; a third of the sharpest blur by default.
  explicit RayFields(const RayGrid& grid, double cell = 0.25);
  /// What may vary along a ray beside top, ground and the chamfer's level: nothing, fields that cross the
  /// chamfer, or the chamfer's own level along the ray.
  enum class Beside { nothing, whole_part, chamfer };
  /// Q_q for a rim.
  std::vector<Eigen::MatrixXd> covariances(const RimOptics& optics, Beside beside) const;

 private:
  int places_, cells_;
  double width_;                                   ///< of a cell, px
  Eigen::VectorXd place_, cell_;                   ///< px from the nominal rim
  std::vector<Eigen::MatrixXd> inside_, outside_;  ///< K_q by correlation length
  Eigen::MatrixXd fine_;
};

/// v_q of one sample covariance, and -2 log of its likelihood per ray less a constant. Starts from
/// `variances` if it holds as many, else from equal ones.
double fit_variances(const Eigen::MatrixXd& sample, const std::vector<Eigen::MatrixXd>& fields,
                     double noise_variance, int iterations, Eigen::VectorXd& variances);

/// sum_q v_q Q_q.
Eigen::MatrixXd field_covariance(const std::vector<Eigen::MatrixXd>& fields,
                                 const Eigen::VectorXd& variances);

}  // namespace tribotrack::vision
