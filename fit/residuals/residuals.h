// All whitened residuals of a problem and their exact derivatives.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <memory>
#include <vector>

#include "fit/residuals/correlated_errors.h"
#include "fit/residuals/failed_evaluations.h"
#include "fit/residuals/point_model.h"
#include "fit/residuals/unknowns.h"

namespace tribotrack::fit::internal {

/// Errors beyond the data's own sigma.
struct ExcessVariance {
  double along = 0, across = 0;  ///< m, between summary runs: along the displacement (v) and across (alpha)
  double runs() const { return std::max(along, across); }
  struct Trajectory {
    double between_points = 0;    ///< m per axis
    double correlation_time = 1;  ///< points per independent point: weights are divided by it
  };
  std::vector<Trajectory> trajectories;
  CorrelatedVariances correlated{};  ///< of driven trajectory runs, common to all
};

/// Weights of a robust loss: the rows of a run or point are multiplied by the root. Empty: all are 1.
struct Weights {
  std::vector<double> runs;                 ///< summary runs
  std::vector<std::vector<double>> points;  ///< trajectory runs
};

/// Unknowns of single runs that have a prior.
enum class Nuisance { phase, spin, deviation, own };

/// Rows of one run after a fit, unwhitened.
struct PointResiduals {
  std::vector<std::size_t> row;  ///< of the track
  std::vector<Eigen::Vector2d> residual;
  std::vector<Eigen::Vector2d> correlated;  ///< expectation of the part that all points share
  /// What is left without it and without what the points before tell of the track's slow errors, and its
  /// covariance by the track, m^2.
  std::vector<Eigen::Vector2d> innovation;
  std::vector<Eigen::Matrix2d> innovation_covariance;
  double rows_taken = 0;  ///< degrees of freedom of that expectation
  Eigen::Vector2d start_point = Eigen::Vector2d::Zero();
};

/// Rows: two a summary run, L^-1 (measured - modelled / scale) with L L' the covariance; two a trajectory
/// point, the run's unknown start point projected out and its correlated errors whitened, then those that all
/// runs share; one a prior, (value - mean)/sd, two a spin. Rows of data are multiplied by the root of their
/// robust weight.
class Residuals {
 public:
  /// Refers to the unknowns and their problem, which must outlive the residuals and all their copies.
  explicit Residuals(const Unknowns& unknowns, int threads = 1);
  explicit Residuals(const Unknowns&& unknowns, int threads = 1) = delete;

  const Unknowns& unknowns() const { return *unknowns_; }
  Eigen::Index size() const { return rows_; }
  /// Independent rows less unknowns (trajectory points divided by their correlation time).
  double degrees_of_freedom() const;
  /// max(1, chi^2/dof): by how much the residuals exceed their sigma.
  double excess(double chi2) const;
  const ExcessVariance& excess_variance() const { return scatter_; }
  void set_excess_variance(const ExcessVariance& scatter);
  /// What SummaryRun::own adds to the covariance of each run, linearised at these values; until then nothing.
  void set_own_errors(const Eigen::VectorXd& values);
  const Weights& weights() const { return weights_; }
  void set_weights(const Weights& weights);
  double run_weight(std::size_t run) const { return weights_.runs.empty() ? 1 : weights_.runs[run]; }
  double point_weight(std::size_t run, std::size_t point) const {
    return weights_.points.empty() ? 1 : weights_.points[run][point];
  }
  /// Error of the integrator, relative to the path.
  void set_tolerance(double tolerance) { tolerance_ = tolerance; }
  /// `share` of the sigma of a typical run or point, relative to its path, within [1e-9, coarsest]: the error
  /// of the integrator that chi^2 tolerates where it is needed to that accuracy only.
  double tolerance_for(double share, double coarsest) const;

  /// False, and recorded in failures(), where the model has no motion at these values (InvalidParameter,
  /// StepLimitExceeded) or the residuals are not finite; any other exception passes. The Jacobian is by
  /// physical values.
  bool evaluate(const Eigen::VectorXd& values, Eigen::VectorXd& residuals, Eigen::MatrixXd* jacobian) const;
  double chi2(const Eigen::VectorXd& values) const;  ///< infinity where evaluate() is false
  /// Of these residuals and all their copies.
  const FailedEvaluations& failures() const { return *failures_; }

  /// Measured less modelled displacement of a summary run, out of the whitened residuals.
  Eigen::Vector2d difference(const Eigen::VectorXd& whitened, std::size_t run) const;
  /// The run's covariance with its own errors and the scatter between runs added.
  Eigen::Matrix2d covariance(std::size_t summary_run) const;
  /// `common` is common_error() of the same values; without it PointResiduals::correlated holds the run's
  /// own.
  PointResiduals points(const Eigen::VectorXd& values, std::size_t trajectory_run,
                        const Eigen::VectorXd& common = {}) const;
  /// Expected errors that all runs share: coefficients of their common shapes, m. Empty without such errors.
  Eigen::VectorXd common_error(const Eigen::VectorXd& values) const;
  /// What SummaryRun::own adds to the covariance of a run.
  Eigen::Matrix2d own_error(std::size_t summary_run) const;
  Eigen::Index first_prior() const;  ///< row of the first prior: behind all data
  struct NuisancePrior {
    Eigen::Index row = 0, rows = 1;
    Nuisance unknown = Nuisance::phase;
  };
  std::vector<NuisancePrior> nuisance_priors() const;
  /// By the root of what the points' own noise is of their whole covariance, in place: what is left of a
  /// column over all trajectory rows if errors that points share are taken out.
  void whiten_shared(Eigen::Ref<Eigen::VectorXd> trajectory_rows) const;
  std::size_t point_count(std::size_t trajectory_run) const;
  Eigen::Index trajectory_row(std::size_t run) const;  ///< the run's first
  /// The rows of a trajectory run whose modelled points are `positions` (m, in the picture), whitened but for
  /// the errors that all runs share; whiten_common() whitens those in all rows of all trajectory runs.
  void whiten(std::size_t trajectory_run, const Eigen::Matrix2Xd& positions,
              Eigen::Ref<Eigen::VectorXd> rows) const;
  void whiten_common(Eigen::Ref<Eigen::VectorXd> column) const;
  /// Shapes of correlated errors over the run's points; none for a free slide.
  ErrorShapes shapes(std::size_t trajectory_run, const ErrorParts& wanted) const;
  /// Columns, two rows a point, whitened as those of the residuals before what all runs share: by the points'
  /// own noise and the track's errors, the start point projected out, and the run's correlated errors.
  Eigen::MatrixXd whitened(std::size_t trajectory_run, Eigen::MatrixXd columns) const;
  /// L^-1 of the points' own noise and slow errors: PointWhitening::shift().
  const Eigen::MatrixX2d& white(std::size_t trajectory_run) const { return prepared_[trajectory_run]->white; }
  double reference_time() const { return reference_time_; }  ///< s, of the longest driven run

 private:
  void summary(const Eigen::VectorXd& values, std::size_t run, Eigen::Ref<Eigen::VectorXd> residuals,
               Eigen::MatrixXd* jacobian, Eigen::Index row) const;
  void trajectory(const Eigen::VectorXd& values, std::size_t run, Eigen::Ref<Eigen::VectorXd> residuals,
                  Eigen::MatrixXd* jacobian, Eigen::Index row) const;
  PointModel modelled_points(const Eigen::VectorXd& values, std::size_t run, bool derivatives) const;
  /// What the rows of a trajectory run need, whatever the unknowns are.
  struct Prepared {
    std::vector<double> times;       ///< s, of its points, from the first
    PointWhitening points;           ///< their noise and slow errors
    Eigen::MatrixX2d white;          ///< behind it, the columns of the start point
    Eigen::MatrixX2d start;          ///< orthonormal, spans `white`
    Eigen::MatrixXd own;             ///< columns of its own errors, those of the track first, not whitened
    CorrelatedWhitening correlated;  ///< of them
    ErrorShapes common;              ///< shapes of the errors that it shares with all runs
  };
  void prepare();
  void prepare_common();
  void prepare(std::size_t trajectory_run);

  const Problem* problem_;
  const Unknowns* unknowns_;
  int threads_;
  double tolerance_ = 1e-10;
  std::vector<std::pair<Eigen::Index, Prior>> priors_;
  /// Of several unknowns together.
  struct JointPrior {
    Eigen::Index unknown;  ///< the first
    Eigen::VectorXd mean;
    Eigen::MatrixXd white;  ///< L^-1
    Nuisance kind;
  };
  std::vector<JointPrior> joint_;
  Eigen::Index prior_rows() const;
  std::vector<std::size_t> first_point_;
  Weights weights_;
  Eigen::Index rows_ = 0;
  ExcessVariance scatter_;
  std::vector<Eigen::Matrix2d> own_;                       ///< m^2, of each summary run
  std::vector<std::shared_ptr<const Prepared>> prepared_;  ///< one for each trajectory run
  std::shared_ptr<const CorrelatedWhitening> common_;      ///< of all trajectory rows; null without
  double reference_time_ = 0;
  std::shared_ptr<FailedEvaluations> failures_ = std::make_shared<FailedEvaluations>();
};

}  // namespace tribotrack::fit::internal
