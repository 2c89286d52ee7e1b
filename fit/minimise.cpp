#include "fit/internal/minimise.h"

#include <ceres/ceres.h>

#include <cmath>
#include <limits>

namespace tribotrack::fit::internal {
namespace {

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

class WholeProblem final : public ceres::CostFunction {
 public:
  WholeProblem(const Residuals& residuals, const Eigen::VectorXd& start, std::optional<Eigen::Index> held)
      : residuals_(residuals), z_(start), held_(held) {
    set_num_residuals(static_cast<int>(residuals.size()));
    mutable_parameter_block_sizes()->push_back(static_cast<int>(start.size()) - (held ? 1 : 0));
  }

  const Residuals& residuals() const { return residuals_; }
  Eigen::VectorXd full(const double* free) const {
    Eigen::VectorXd z = z_;
    for (Eigen::Index i = 0, j = 0; i < z.size(); ++i)
      if (i != held_) z(i) = free[j++];
    return z;
  }
  std::vector<double> free_part() const {
    std::vector<double> free;
    for (Eigen::Index i = 0; i < z_.size(); ++i)
      if (i != held_) free.push_back(z_(i));
    return free;
  }

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    const Eigen::VectorXd z = full(parameters[0]);
    const auto& unknowns = residuals_.unknowns();
    const bool wanted = jacobians && jacobians[0];
    // A point is asked for its cost first and, nearly always, for its Jacobian next: one simulation does
    // both.
    if (last_z_.size() != z.size() || last_z_ != z) {
      last_z_ = z;
      last_good_ = z.allFinite() && residuals_.evaluate(unknowns.values(z), last_residuals_, &last_jacobian_);
    }
    if (!last_good_) return false;
    const Eigen::VectorXd& r = last_residuals_;
    const Eigen::MatrixXd& by_value = last_jacobian_;
    Eigen::Map<Eigen::VectorXd>(residuals, r.size()) = r;
    if (!wanted) return true;
    const Eigen::VectorXd slopes = unknowns.slopes(z);
    Eigen::Map<RowMajor> jacobian(jacobians[0], r.size(), parameter_block_sizes()[0]);
    for (Eigen::Index i = 0, j = 0; i < z.size(); ++i)
      if (i != held_) jacobian.col(j++) = by_value.col(i) * slopes(i);
    return true;
  }

 private:
  const Residuals& residuals_;
  Eigen::VectorXd z_;
  std::optional<Eigen::Index> held_;
  mutable Eigen::VectorXd last_z_, last_residuals_;  ///< one solver, one thread
  mutable Eigen::MatrixXd last_jacobian_;
  mutable bool last_good_ = false;
};

/// Ends a descent that has come within a fifth of a standard deviation of a minimum already known.
class JoinsKnown final : public ceres::IterationCallback {
 public:
  JoinsKnown(const std::vector<KnownMinimum>& known, const WholeProblem& cost,
             const std::vector<double>& free)
      : known_(known), cost_(cost), free_(free) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary& summary) override {
    const Eigen::VectorXd z = cost_.full(free_.data());
    for (const auto& [minimum, curvature] : known_) {
      const Eigen::VectorXd distance = z - minimum.z;
      const double above = 2 * summary.cost - minimum.chi2;
      const double spread = cost_.residuals().excess(minimum.chi2);
      if (distance.dot(curvature * distance) < 0.04 * spread && above < 0.08 * spread) {
        joined = true;
        return ceres::SOLVER_TERMINATE_SUCCESSFULLY;
      }
    }
    return ceres::SOLVER_CONTINUE;
  }
  bool joined = false;

 private:
  const std::vector<KnownMinimum>& known_;
  const WholeProblem& cost_;
  const std::vector<double>& free_;
};

}  // namespace

Minimum minimise(const Residuals& residuals, const Eigen::VectorXd& start, const MinimiseOptions& options) {
  WholeProblem cost(residuals, start, options.held);
  std::vector<double> free = cost.free_part();
  Minimum minimum;
  if (free.empty()) {
    minimum.z = start;
    minimum.chi2 = residuals.chi2(residuals.unknowns().values(start));
    minimum.converged = std::isfinite(minimum.chi2);
    return minimum;
  }
  ceres::Problem::Options ownership;
  ownership.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem problem(ownership);
  problem.AddResidualBlock(&cost, nullptr, free.data());

  ceres::Solver::Options solver;
  solver.linear_solver_type = ceres::DENSE_QR;
  solver.num_threads = 1;
  solver.logging_type = ceres::SILENT;
  solver.max_num_iterations = options.max_iterations;
  solver.function_tolerance = options.function_tolerance;
  solver.gradient_tolerance = 1e-14;
  solver.parameter_tolerance = 1e-11;
  solver.initial_trust_region_radius = 100;
  const std::vector<KnownMinimum> none;
  JoinsKnown callback(options.known ? *options.known : none, cost, free);
  if (options.known && !options.known->empty()) {
    solver.callbacks.push_back(&callback);
    solver.update_state_every_iteration = true;
  }
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem, &summary);

  minimum.z = cost.full(free.data());
  minimum.chi2 =
      summary.IsSolutionUsable() ? 2 * summary.final_cost : std::numeric_limits<double>::infinity();
  minimum.converged =  // IsSolutionUsable() is true for NO_CONVERGENCE, too
      summary.termination_type == ceres::CONVERGENCE || summary.termination_type == ceres::USER_SUCCESS;
  minimum.joined = callback.joined;
  return minimum;
}

KnownMinimum with_curvature(const Residuals& residuals, const Minimum& minimum) {
  Eigen::VectorXd r;
  Eigen::MatrixXd jacobian;
  const auto& unknowns = residuals.unknowns();
  if (!residuals.evaluate(unknowns.values(minimum.z), r, &jacobian))
    return {minimum, Eigen::MatrixXd::Zero(minimum.z.size(), minimum.z.size())};
  jacobian = jacobian * unknowns.slopes(minimum.z).asDiagonal();
  return {minimum, jacobian.transpose() * jacobian};
}

}  // namespace tribotrack::fit::internal
