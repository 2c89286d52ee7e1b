// All whitened residuals of a problem and their exact derivatives.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <memory>
#include <vector>

#include "fit/residuals/correlated_errors.h"
#include "fit/residuals/point_model.h"
#include "fit/residuals/unknowns.h"

namespace tribotrack::fit::internal {

/// What the data scatter beyond their own sigma.
struct Scatter {
  double along = 0, across = 0;  ///< m, between summary runs: along the displacement (v) and across (alpha)
  double runs() const { return std::max(along, across); }
  struct Trajectory {
    double between_points = 0;    ///< m per axis
    double correlation_time = 1;  ///< points per independent point: weights are divided by it
  };
  std::vector<Trajectory> trajectories;
  SlowVariances slow{};  ///< of driven trajectory runs, common to all
};

/// What a robust loss makes of each run and point: its rows are multiplied by the root. Empty: all count
/// fully.
struct Weights {
  std::vector<double> runs;                 ///< summary runs
  std::vector<std::vector<double>> points;  ///< trajectory runs
};

/// Rows of one run after a fit, unwhitened.
struct PointResiduals {
  std::vector<std::size_t> row;  ///< of the track
  std::vector<Eigen::Vector2d> residual;
  std::vector<Eigen::Vector2d> slow;  ///< of the residual, what its own slow error is expected to be
  double rows_taken = 0;              ///< by that expectation
  Eigen::Vector2d start_point = Eigen::Vector2d::Zero();
};

/// Rows: two a summary run, L^-1 (measured - modelled / scale) with L L' the covariance; two a trajectory
/// point, the run's unknown start point projected out and its slow errors whitened, then those that all runs
/// share; one a prior, (value - mean)/sd. Rows of data are multiplied by the root of their robust weight.
class Residuals {
 public:
  /// Both must outlive the residuals.
  Residuals(const Problem& problem, const Unknowns& unknowns, int threads = 1);

  const Unknowns& unknowns() const { return *unknowns_; }
  Eigen::Index size() const { return rows_; }
  /// Independent rows less unknowns (trajectory points divided by their correlation time).
  double degrees_of_freedom() const;
  /// max(1, chi^2/dof): by how much the residuals exceed their sigma.
  double excess(double chi2) const;
  const Scatter& scatter() const { return scatter_; }
  void set_scatter(const Scatter& scatter);
  const Weights& weights() const { return weights_; }
  void set_weights(const Weights& weights);
  double run_weight(std::size_t run) const { return weights_.runs.empty() ? 1 : weights_.runs[run]; }
  double point_weight(std::size_t run, std::size_t point) const {
    return weights_.points.empty() ? 1 : weights_.points[run][point];
  }
  /// Of the integrator, relative to the path.
  void set_tolerance(double tolerance) { tolerance_ = tolerance; }
  /// `share` of the sigma of a typical run or point, relative to its path, within [1e-9, coarsest]: what the
  /// integrator may err by where only chi-square of that sharpness is asked for.
  double tolerance_for(double share, double coarsest) const;

  /// False where the model cannot be evaluated. The Jacobian is by physical values.
  bool evaluate(const Eigen::VectorXd& values, Eigen::VectorXd& residuals, Eigen::MatrixXd* jacobian) const;
  double chi2(const Eigen::VectorXd& values) const;  ///< infinity where the model cannot be evaluated

  /// Measured less modelled displacement of a summary run, out of the whitened residuals.
  Eigen::Vector2d difference(const Eigen::VectorXd& whitened, std::size_t run) const;
  /// The run's covariance with the scatter between runs added.
  Eigen::Matrix2d covariance(std::size_t summary_run) const;
  /// `common` is common_error() of the same values; without it PointResiduals::slow holds the run's own.
  PointResiduals points(const Eigen::VectorXd& values, std::size_t trajectory_run,
                        const Eigen::VectorXd& common = {}) const;
  /// What all runs are expected to err by together: coefficients of their common shapes, m. Empty without
  /// such errors.
  Eigen::VectorXd common_error(const Eigen::VectorXd& values) const;
  std::size_t point_count(std::size_t trajectory_run) const;
  Eigen::Index trajectory_row(std::size_t run) const;  ///< the run's first
  /// The rows of a trajectory run whose modelled points are `positions` (m, in the picture), but for what all
  /// runs share; whiten_common() does that to all rows of all trajectory runs.
  void whiten(std::size_t trajectory_run, const Eigen::Matrix2Xd& positions,
              Eigen::Ref<Eigen::VectorXd> rows) const;
  void whiten_common(Eigen::Ref<Eigen::VectorXd> column) const;
  /// Shapes of slow errors over the run's points; none for a free slide.
  SlowShapes shapes(std::size_t trajectory_run, const SlowWanted& wanted) const;
  /// L^-1 of every point, one above the other, times the roots of their weights.
  const Eigen::MatrixX2d& white(std::size_t trajectory_run) const { return prepared_[trajectory_run]->white; }
  double slow_reference_time() const { return slow_reference_time_; }  ///< s, of the longest driven run

 private:
  void summary(const Eigen::VectorXd& values, std::size_t run, Eigen::Ref<Eigen::VectorXd> residuals,
               Eigen::MatrixXd* jacobian, Eigen::Index row) const;
  void trajectory(const Eigen::VectorXd& values, std::size_t run, Eigen::Ref<Eigen::VectorXd> residuals,
                  Eigen::MatrixXd* jacobian, Eigen::Index row) const;
  PointModel modelled_points(const Eigen::VectorXd& values, std::size_t run, bool derivatives) const;
  /// What a trajectory run's rows need and no value of the unknowns changes.
  struct Prepared {
    std::vector<double> times;  ///< s, of its points, from the first
    Eigen::MatrixX2d white;     ///< also the columns of the start point
    Eigen::MatrixX2d start;     ///< orthonormal, spans `white`
    SlowWhitening slow;         ///< of its own errors
    SlowShapes common;          ///< shapes of the errors that it shares with all runs
  };
  void prepare();
  void prepare_common();
  void prepare(std::size_t trajectory_run);

  const Problem* problem_;
  const Unknowns* unknowns_;
  int threads_;
  double tolerance_ = 1e-10;
  std::vector<std::pair<Eigen::Index, Prior>> priors_;
  std::vector<std::size_t> first_point_;
  Weights weights_;
  Eigen::Index rows_ = 0;
  Scatter scatter_;
  std::vector<std::shared_ptr<const Prepared>> prepared_;  ///< one for each trajectory run
  std::shared_ptr<const SlowWhitening> common_;            ///< of all trajectory rows; null without
  double slow_reference_time_ = 0;
};

}  // namespace tribotrack::fit::internal
