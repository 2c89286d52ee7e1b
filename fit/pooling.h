// One quantity measured in several runs of one campaign: is it one, and what is it?
//
//   std::vector<Estimate> amplitudes;                       // of the runs' markers, each with its own sd
//   const Pooled all = pool(amplitudes);                    // sds: without what is the same error in all
//   if (all.one_value()) use(all.mean);                     // else each run keeps its own
//   const Estimate best = combined(given, all.mean);        // a second, independent opinion
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "fit/measurement.h"

namespace tribotrack::fit {

/// Below this chance of so large a chi2 the runs are said to differ: one campaign in a thousand by mistake.
inline constexpr double kRefusedByChance = 1e-3;

struct Pooled {
  Estimate mean;
  double chi2 = 0;  ///< of the runs about their mean, count - 1 degrees of freedom
  double p_value = 1;
  std::size_t count = 0;
  bool one_value() const { return p_value >= kRefusedByChance; }
};

/// The mean weighted by 1/s_k^2, s_k the runs' own sds:
///   mean = sum x_k / s_k^2 / W,  W = sum 1 / s_k^2,  sd^2 = 1 / W,  chi2 = sum (x_k - mean)^2 / s_k^2.
/// Where chi2 refuses one value the sd is that of the mean under the scatter seen, larger by sqrt(chi2 / dof)
/// [Birge, Phys. Rev. 40, 207 (1932)]. Values without an sd of their own are exact: equal, or refused.
/// Throws std::invalid_argument for an empty list or an sd that is negative or no number.
Pooled pool(std::span<const Estimate> values);

/// Angles: the same about the first of them, so that no turn counts. The mean lies within pi of the first.
Pooled pool_angles(std::span<const Estimate> values);

/// The mean of two independent estimates of one quantity, weighted by 1/sd^2. One without an sd is exact:
/// it is the result (the first, where both are).
Estimate combined(const Estimate& first, const Estimate& second);

/// Quantities known together, told one of them once more: values + k (seen - value_i), covariance - k c_i',
/// k = c_i / (c_ii + sd^2), c_i column i of the covariance (one step of a Kalman filter).
void take_in(Eigen::VectorXd& values, Eigen::MatrixXd& covariance, Eigen::Index i, const Estimate& seen);

/// A motion as alpha and v. An sd of 0: not known.
struct AlphaV {
  Estimate alpha;     ///< rad
  Estimate velocity;  ///< m/s
};

/// One measurement of a point that others may repeat.
struct PointMeasurement {
  std::size_t point = 0;  ///< 0, 1, ...
  AlphaV value;
};

/// The scatter of one measurement about its point, found from repeats.
struct RepeatScatter {
  double sd = 0;  ///< 0: not needed, or not known
  /// sd is a share of the velocity (of alpha: rad), else m/s.
  bool relative = false;
  std::size_t dof = 0;  ///< measurements less points
};

/// Points with their repeats pooled.
struct PooledPoints {
  std::vector<AlphaV> points;   ///< an sd is 0 where none was given and no point was measured twice
  RepeatScatter along, across;  ///< of the velocity vector: of v, and of alpha
  double widened = 1;           ///< by Student's t, at most, in the sds that come from the scatter
  double chi2 = 0;              ///< of the repeats about their means, where sds were given
  std::size_t chi2_dof = 0;
  double p_value = 1;
  double scattered = 1;  ///< by which all sds are larger where chi2 refuses them; else 1
};

/// The mean velocity vector of each point, so that directions on both sides of 0 = 2 pi are near each other.
/// Along the point's plain mean, and across it, every measurement counts with 1/sd^2 (v sd(alpha) across).
/// n measurements of one sd give sd / sqrt(n).
///
/// Where a measurement has no sd, that of all such measurements is the scatter of the repeats about their
/// points' means, s^2 = sum (x - mean)^2 / dof, pooled over all points, along and across each: as one speed
/// or as one share of each point's speed (across: one angle), whichever makes the repeats more likely. A fit
/// counts an sd as known, with 1.96 of it on either side: s is widened by t(0.975, dof) / 1.96, which makes
/// that Student's interval.
///
/// Where sds are given and chi2 of the repeats refuses them all are widened by sqrt(chi2 / dof), those of
/// points measured once as well: they were measured in the same way. Throws std::invalid_argument where a
/// value is no number, an sd or a velocity is negative, or a point below the highest has no measurement.
PooledPoints pool_points(std::span<const PointMeasurement> measurements);

}  // namespace tribotrack::fit
