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
#include <vector>

#include "vision/edge/rays.h"

namespace tribotrack::vision {

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
