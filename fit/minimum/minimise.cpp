#include "fit/minimum/minimise.h"

#include <ceres/ceres.h>
#include <glog/logging.h>
#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>
#include <memory>
#include <utility>

#include "fit/estimate.h"
#include "fit/tools/thresholds.h"

namespace tribotrack::fit {

const char* solver() {
  return "Ceres " CERES_VERSION_STRING;
}

}  // namespace tribotrack::fit

namespace tribotrack::fit::internal {
namespace {

/// Ceres writes to standard error where an evaluation fails, silent or not.
void quieten() {
  static const bool once = [] {
    FLAGS_minloglevel = google::GLOG_FATAL;
    return true;
  }();
  static_cast<void>(once);
}

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// The point that Ceres looks at, all rows evaluated together.
class Evaluation final : public ceres::EvaluationCallback {
 public:
  Evaluation(const Residuals& residuals, const Eigen::VectorXd& start) : z(start), residuals_(residuals) {}

  struct Point {
    Eigen::VectorXd z;
    Linearised at, by_z;  ///< by values and by z
  };

  Eigen::VectorXd z;  ///< where Ceres keeps it

  void PrepareForEvaluation(bool, bool) override { here(); }

  /// Ceres needs the cost at a point first and, nearly always, its Jacobian next: one simulation does both.
  /// Null where there is no motion.
  const Point* here() {
    if (const Point* point = known()) return point;
    if (!z.allFinite() || (failed_.size() == z.size() && failed_ == z)) return nullptr;
    auto at = residuals_.at(residuals_.unknowns().values(z));
    if (!at) {
      failed_ = z;
      return nullptr;
    }
    return &keep(std::move(*at));
  }
  /// The last point or the lowest, which a step that was refused may lie behind; null for any other.
  const Point* known() const {
    const auto is_here = [&](const std::shared_ptr<Point>& point) { return point && point->z == z; };
    return is_here(last_) ? last_.get() : is_here(best_) ? best_.get() : nullptr;
  }
  const Point& keep(Linearised at) {
    last_ = std::make_shared<Point>(Point{z, std::move(at), {}});
    last_->by_z = last_->at.scaled(residuals_.unknowns().slopes(z));
    if (!best_ || last_->at.chi2() < best_->at.chi2()) best_ = last_;
    return *last_;
  }

 private:
  const Residuals& residuals_;
  std::shared_ptr<Point> last_, best_;  ///< one solver, one thread
  Eigen::VectorXd failed_;
};

/// Rows of one group by what all runs share and by its own.
class GroupCost final : public ceres::CostFunction {
 public:
  GroupCost(Evaluation& evaluation, std::size_t group, Eigen::Index rows, Eigen::Index shared,
            Eigen::Index own)
      : evaluation_(evaluation), group_(group) {
    set_num_residuals(static_cast<int>(rows));
    mutable_parameter_block_sizes()->push_back(static_cast<int>(shared));
    if (own > 0) mutable_parameter_block_sizes()->push_back(static_cast<int>(own));
  }
  bool Evaluate(double const* const*, double* residuals, double** jacobians) const override {
    const Evaluation::Point* point = evaluation_.here();
    if (!point) return false;
    const RowGroup& rows = point->by_z.groups[group_];
    Eigen::Map<Eigen::VectorXd>(residuals, num_residuals()) = rows.residuals;
    if (!jacobians) return true;
    const auto fill = [&](std::size_t block, const Eigen::MatrixXd& columns) {
      if (block < parameter_block_sizes().size() && jacobians[block])
        Eigen::Map<RowMajor>(jacobians[block], columns.rows(), columns.cols()) = columns;
    };
    fill(0, rows.shared);
    fill(1, rows.own);
    return true;
  }

 private:
  Evaluation& evaluation_;
  std::size_t group_;
};

/// Ends a descent that has arrived, has come within a fifth of a standard deviation of a minimum already
/// known, or crawls far above one.
class Watch final : public ceres::IterationCallback {
 public:
  Watch(const Residuals& residuals, const MinimiseOptions& options, Evaluation& evaluation)
      : residuals_(residuals), options_(options), evaluation_(evaluation) {}

  ceres::CallbackReturnType operator()(const ceres::IterationSummary& summary) override {
    const double chi2 = 2 * summary.cost;
    if (options_.known) {
      double lowest = HUGE_VAL, spread = 1;
      for (const Minimum& minimum : *options_.known) {
        const double excess = residuals_.excess(minimum.chi2);
        if (minimum.chi2 < lowest) lowest = minimum.chi2, spread = excess;
        if (chi2 - minimum.chi2 < 0.08 * excess &&
            minimum.distance(residuals_.unknowns(), evaluation_.z) < 0.04 * excess) {
          joined = true;
          return ceres::SOLVER_TERMINATE_SUCCESSFULLY;
        }
      }
      if (crawls(summary, chi2, lowest, spread)) {
        abandoned = true;
        return ceres::SOLVER_TERMINATE_SUCCESSFULLY;
      }
    }
    if (!(lowest_ - chi2 < (options_.patient ? 1e-4 : 0.01))) lowest_ = chi2, since_ = summary.iteration;
    if (summary.iteration - since_ >= (options_.patient ? 8 : 4)) return ceres::SOLVER_TERMINATE_SUCCESSFULLY;
    const Evaluation::Point* point = evaluation_.known();
    return point && newton_decrement(point->by_z, options_.held) < options_.decrement
               ? ceres::SOLVER_TERMINATE_SUCCESSFULLY
               : ceres::SOLVER_CONTINUE;
  }

  bool joined = false, abandoned = false;

 private:
  /// Three steps in a row that gain less than a tenth of the way down to what would be worth telling.
  bool crawls(const ceres::IterationSummary& summary, double chi2, double lowest, double spread) {
    const double above = chi2 - lowest - kNearMinimum * spread;
    const bool slow = summary.iteration > 0 && above > 0 && 2 * std::abs(summary.cost_change) < 0.1 * above;
    slow_steps_ = slow ? slow_steps_ + 1 : 0;
    return slow_steps_ >= 3 && summary.step_is_successful;
  }

  const Residuals& residuals_;
  const MinimiseOptions& options_;
  Evaluation& evaluation_;
  int slow_steps_ = 0, since_ = 0;
  double lowest_ = HUGE_VAL;
};

ceres::Solver::Options solver_options(const MinimiseOptions& options) {
  ceres::Solver::Options solver;
  solver.linear_solver_type = ceres::DENSE_QR;
  solver.num_threads = 1;
  solver.logging_type = ceres::SILENT;
  solver.max_num_iterations = options.max_iterations;
  solver.function_tolerance = 1e-15;  // the watch stops earlier
  solver.gradient_tolerance = 1e-14;
  solver.parameter_tolerance = 1e-11;
  // By the wall clock, which may be set from 1970 to today meanwhile.
  solver.max_solver_time_in_seconds = std::numeric_limits<double>::infinity();
  solver.initial_trust_region_radius = 100;
  solver.update_state_every_iteration = true;
  return solver;
}

}  // namespace

double Minimum::distance(const Unknowns& unknowns, const Eigen::VectorXd& other) const {
  return at.squared(unknowns.slopes(z).cwiseProduct(other - z));
}

Minimum minimise(const Residuals& residuals, const Eigen::VectorXd& start, const MinimiseOptions& options) {
  const Unknowns& unknowns = residuals.unknowns();
  Evaluation evaluation(residuals, start);
  Minimum minimum;
  if (options.held && unknowns.size() == 1) {
    minimum.z = start;
    minimum.chi2 = residuals.chi2(unknowns.values(start));
    minimum.converged = std::isfinite(minimum.chi2);
    return minimum;
  }
  quieten();
  ceres::Problem::Options ownership;
  ownership.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ownership.evaluation_callback = &evaluation;
  ceres::Problem problem(ownership);
  ceres::Solver::Options solver = solver_options(options);
  const auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  double* const shared = evaluation.z.data();
  std::deque<GroupCost> costs;
  const auto& groups = residuals.layout().groups;
  for (std::size_t group = 0; group < groups.size(); ++group) {
    const auto& [data, rows, own] = groups[group];
    if (rows == 0) continue;
    costs.emplace_back(evaluation, group, rows, unknowns.common(), own.count);
    std::vector<double*> blocks{shared};
    if (own.count > 0) {
      blocks.push_back(shared + own.first);
      ordering->AddElementToGroup(blocks.back(), 0);
      solver.linear_solver_type = ceres::DENSE_SCHUR;
    }
    problem.AddResidualBlock(&costs.back(), nullptr, blocks);
  }
  if (options.held && unknowns.common() == 1)
    problem.SetParameterBlockConstant(shared);
  else if (options.held)
    problem.SetManifold(shared, new ceres::SubsetManifold(static_cast<int>(unknowns.common()),
                                                          {static_cast<int>(*options.held)}));
  if (solver.linear_solver_type == ceres::DENSE_SCHUR) {
    ordering->AddElementToGroup(shared, 1);
    solver.linear_solver_ordering = ordering;
  }
  Watch watch(residuals, options, evaluation);
  solver.callbacks.push_back(&watch);
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem, &summary);

  minimum.z = evaluation.z;
  minimum.chi2 =
      summary.IsSolutionUsable() ? 2 * summary.final_cost : std::numeric_limits<double>::infinity();
  minimum.converged =  // IsSolutionUsable() is true for NO_CONVERGENCE, too
      summary.termination_type == ceres::CONVERGENCE || summary.termination_type == ceres::USER_SUCCESS;
  minimum.joined = watch.joined;
  minimum.abandoned = watch.abandoned;
  if (const Evaluation::Point* point = evaluation.known())
    minimum.at = point->at;
  else if (std::isfinite(minimum.chi2))
    minimum = linearised(residuals, std::move(minimum));
  return minimum;
}

Minimum linearised(const Residuals& residuals, Minimum minimum) {
  if (minimum.at.empty())
    if (auto here = residuals.at(residuals.unknowns().values(minimum.z))) minimum.at = std::move(*here);
  return minimum;
}

}  // namespace tribotrack::fit::internal
