// All whitened residuals of a problem and their exact derivatives.
//
// Rows: two a summary run, L^-1 (measured - modelled / scale) with L L' the covariance; two a trajectory
// point (track_whitening.h). Rows of summary runs are multiplied by the root of their robust weight. One row
// a prior, (value - mean)/sd. Group 0 holds summary runs and priors of what all runs share; then there is one
// group for each trajectory run, its points and the priors of its own unknowns.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "fit/residuals/linear_terms.h"
#include "fit/residuals/linearised.h"
#include "fit/residuals/track_whitening.h"
#include "fit/residuals/unknowns.h"
#include "model/trajectory.h"

namespace tribotrack::fit::internal {

struct PointModel {
  Eigen::Matrix2Xd positions;  ///< m, in the picture (divided by the scale)
  Eigen::MatrixXd jacobian;    ///< 2n x columns of the chain, x and y of a point below each other
  long steps = 0;              ///< of the integration
};

/// How the points were seen.
struct Seen {
  bool camera_frame = false;  ///< the platform's own motion is in them
  double exposure = 0;        ///< s: a point is the mean over it
};

/// At `times` (s from the start). Throws as model::integrate(), beyond Unknowns::most_steps() and `max_steps`
/// too.
PointModel model_points(const Unknowns& unknowns, const AppliedScenario& applied,
                        const std::vector<double>& times, const Seen& seen, double tolerance,
                        bool derivatives, long max_steps = model::IntegrationOptions{}.max_steps);

/// Errors beyond the data's own sigma.
struct ExcessVariance {
  double runs = 0;  ///< m per axis, between summary runs
  std::vector<PointScatter> trajectories;
  CorrelatedVariances correlated{};  ///< of driven trajectory runs, common to all
};

/// Where rows and unknowns are: the group of summary runs and shared priors, then one of each trajectory run.
struct RowLayout {
  struct Group {
    Eigen::Index data = 0, rows = 0;  ///< rows of data; with the priors behind them
    Range own;                        ///< unknowns of its run alone
  };
  std::vector<Group> groups;
  Eigen::Index rows() const;  ///< of all groups
};

class Residuals {
 public:
  /// Refers to the unknowns and their problem, which must outlive the residuals and all their copies.
  explicit Residuals(const Unknowns& unknowns, int threads = 1);
  explicit Residuals(const Unknowns&& unknowns, int threads = 1) = delete;

  // What the residuals are whitened by.
  const ExcessVariance& excess_variance() const { return excess_; }
  void set_excess_variance(const ExcessVariance& excess);
  /// Of summary runs, by a robust loss; empty: all are 1.
  void set_weights(const std::vector<double>& weights) { weights_ = weights; }
  const std::vector<double>& weights() const { return weights_; }
  double weight(std::size_t summary_run) const { return weights_.empty() ? 1 : weights_[summary_run]; }
  /// Added to the residuals as they are without weights, group by group; empty: nothing is.
  void set_shift(std::vector<Eigen::VectorXd> shift) { shift_ = std::move(shift); }
  /// What SummaryRun::own adds to the covariance of each run, linearised at these values; until then nothing.
  void set_own_errors(const Eigen::VectorXd& values);
  const Eigen::Matrix2d& own_error(std::size_t summary_run) const { return own_[summary_run]; }
  /// The run's covariance with its own errors and the scatter between runs added.
  Eigen::Matrix2d covariance(std::size_t summary_run) const;
  const TrackWhitening& track(std::size_t trajectory_run) const { return *tracks_[trajectory_run]; }
  double reference_time() const { return reference_time_; }  ///< s, of the longest driven run

  // What they are.
  const Unknowns& unknowns() const { return *unknowns_; }
  /// Error of the integrator, relative to the path.
  void set_tolerance(double tolerance) { tolerance_ = tolerance; }
  double tolerance() const { return tolerance_; }
  /// `share` of the sigma of a typical run or point, relative to its path, within [1e-9, coarsest]: the error
  /// of the integrator that chi^2 tolerates where it is needed to that accuracy only.
  double tolerance_for(double share, double coarsest) const;
  /// Summary runs linear in the conditions from here on, about these values (linear_terms.h); until then they
  /// are not, and laws of friction among them add nothing. False, and as before: there is no motion there.
  bool linearise(const Eigen::VectorXd& values);
  bool linear_in_conditions() const { return terms_ != nullptr; }

  /// nullopt, and `why`, where the model has no motion at these values (InvalidParameter, StepLimitExceeded)
  /// or the residuals are not finite; any other exception passes. Derivatives are by physical values.
  std::optional<Linearised> at(const Eigen::VectorXd& values, bool derivatives = true,
                               std::string* why = nullptr) const;
  double chi2(const Eigen::VectorXd& values) const;  ///< infinity where at() has none

  const RowLayout& layout() const { return layout_; }
  /// Independent rows less unknowns (trajectory points divided by their correlation time).
  double degrees_of_freedom() const;
  /// Those of the tracks' own variances, where these were estimated from the points; infinite without such.
  double noise_degrees_of_freedom() const;
  /// That chance makes chi^2 so large, `more` unknowns being free beside those there are.
  double p_value(double chi2, int more = 0) const;
  /// max(1, chi^2/dof): by how much the residuals exceed their sigma.
  double excess(double chi2) const;

  /// Measured less modelled displacement of a summary run, and the modelled one's derivatives by what all
  /// share.
  Eigen::Vector2d difference(const Linearised& at, std::size_t summary_run) const;
  Eigen::Matrix2Xd derivatives(const Linearised& at, std::size_t summary_run) const;
  PointResiduals points(const Eigen::VectorXd& values, std::size_t trajectory_run) const;

 private:
  double root_of_weight(std::size_t summary_run) const;
  void summary(const Eigen::VectorXd& values, std::size_t run, bool derivatives, RowGroup& group) const;
  RowGroup trajectory(const Eigen::VectorXd& values, std::size_t run, bool derivatives) const;
  PointModel modelled_points(const Eigen::VectorXd& values, std::size_t run, bool derivatives) const;
  void prepare();

  const Problem* problem_;
  const Unknowns* unknowns_;
  int threads_;
  double tolerance_ = 1e-10;
  std::vector<Eigen::Index> differentiated_;  ///< shared unknowns by which summary runs are, in each step
  std::shared_ptr<const LinearTerms> terms_;  ///< null: none
  std::vector<std::pair<Eigen::Index, Prior>> priors_;  ///< of what all runs share
  ExcessVariance excess_;
  std::vector<double> weights_;
  std::vector<Eigen::VectorXd> shift_;
  std::vector<Eigen::Matrix2d> own_;  ///< m^2, of each summary run
  std::vector<std::size_t> first_point_;
  std::vector<std::shared_ptr<const TrackWhitening>> tracks_;
  RowLayout layout_;
  double reference_time_ = 0;
};

}  // namespace tribotrack::fit::internal
