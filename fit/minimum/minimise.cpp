#include "fit/minimum/minimise.h"

#include <ceres/ceres.h>
#include <glog/logging.h>
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "fit/estimate.h"
#include "fit/tools/dense.h"
#include "fit/tools/thresholds.h"

namespace tribotrack::fit {

const char* solver() {
  return "Ceres " CERES_VERSION_STRING;
}

}  // namespace tribotrack::fit

namespace tribotrack::fit::internal {
namespace {

/// Ceres writes to standard error where an evaluation fails, silent or not; Residuals counts that and callers
/// tell it in their own words.
void quieten() {
  static const bool once = [] {
    FLAGS_minloglevel = google::GLOG_FATAL;
    return true;
  }();
  static_cast<void>(once);
}

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

class WholeProblem final : public ceres::CostFunction {
 public:
  WholeProblem(const Residuals& residuals, const Eigen::VectorXd& start, std::optional<Eigen::Index> held)
      : residuals_(residuals), z_(start), held_(held) {
    set_num_residuals(static_cast<int>(compressed_rows(residuals.size(), start.size())));
    mutable_parameter_block_sizes()->push_back(static_cast<int>(start.size()) - (held ? 1 : 0));
  }

  /// Residuals and Jacobian (by physical values) at a point.
  struct Point {
    Eigen::VectorXd z, residuals;
    Eigen::MatrixXd jacobian;
    Rows rows;  ///< the same, compressed
    bool is_at(const Eigen::VectorXd& place) const { return z.size() == place.size() && z == place; }
  };

  void remember(const Minimum& evaluated) {
    last_ = best_ = std::make_shared<Point>(Point{evaluated.z, evaluated.residuals, evaluated.jacobian,
                                                  compress(evaluated.jacobian, evaluated.residuals)});
  }
  const Residuals& residuals() const { return residuals_; }
  /// The last point or the lowest, which a step that was refused may lie behind; null for any other.
  const Point* known(const Eigen::VectorXd& z) const {
    return last_ && last_->is_at(z) ? last_.get() : best_ && best_->is_at(z) ? best_.get() : nullptr;
  }
  /// By the free z, compressed.
  Eigen::MatrixXd free_jacobian(const Point& point) const {
    const Eigen::VectorXd slopes = residuals_.unknowns().slopes(point.z);
    Eigen::MatrixXd jacobian(point.rows.jacobian.rows(), parameter_block_sizes()[0]);
    for (Eigen::Index i = 0, j = 0; i < point.z.size(); ++i)
      if (i != held_) jacobian.col(j++) = point.rows.jacobian.col(i) * slopes(i);
    return jacobian;
  }
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
    // Ceres needs the cost at a point first and, nearly always, its Jacobian next: one simulation does
    // both.
    const Point* point = known(z);
    if (!point) {
      // Room of the point before last, where that is not the lowest.
      if (!last_ || last_ == best_) last_ = std::make_shared<Point>();
      Point& here = *last_;
      here.z.resize(0);
      if (!z.allFinite() ||
          !residuals_.evaluate(residuals_.unknowns().values(z), here.residuals, &here.jacobian))
        return false;
      here.z = z;
      here.rows = compress(here.jacobian, here.residuals);
      if (!best_ || here.rows.residuals.squaredNorm() < best_->rows.residuals.squaredNorm()) best_ = last_;
      point = last_.get();
    }
    Eigen::Map<Eigen::VectorXd>(residuals, num_residuals()) = point->rows.residuals;
    if (jacobians && jacobians[0])
      Eigen::Map<RowMajor>(jacobians[0], num_residuals(), parameter_block_sizes()[0]) = free_jacobian(*point);
    return true;
  }

 private:
  const Residuals& residuals_;
  Eigen::VectorXd z_;
  std::optional<Eigen::Index> held_;
  mutable std::shared_ptr<Point> last_, best_;  ///< one solver, one thread
};

/// r'J (J'J)^-1 J'r, directions the data do not see left out.
double newton_decrement(const Eigen::VectorXd& r, const Eigen::MatrixXd& jacobian) {
  const Eigen::MatrixXd normal = jacobian.transpose() * jacobian;
  const Eigen::VectorXd scale = normal.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const EigenSystem eigen = eigen_symmetric(scale.asDiagonal() * normal * scale.asDiagonal());
  const Eigen::VectorXd along = eigen.vectors.transpose() * (scale.asDiagonal() * (jacobian.transpose() * r));
  double sum = 0;
  for (Eigen::Index i = 0; i < along.size(); ++i)
    if (eigen.values(i) > 1e-13) sum += along(i) * along(i) / eigen.values(i);
  return sum;
}

/// Ends a descent that has arrived, has come within a fifth of a standard deviation of a minimum already
/// known, or crawls far above one.
class Watch final : public ceres::IterationCallback {
 public:
  Watch(const MinimiseOptions& options, const WholeProblem& cost, const std::vector<double>& free)
      : options_(options), cost_(cost), free_(free) {}

  ceres::CallbackReturnType operator()(const ceres::IterationSummary& summary) override {
    const Eigen::VectorXd z = cost_.full(free_.data());
    const double chi2 = 2 * summary.cost;
    if (options_.known) {
      double lowest = HUGE_VAL, spread = 1;
      for (const auto& [minimum, curvature] : *options_.known) {
        const Eigen::VectorXd distance = z - minimum.z;
        const double excess = cost_.residuals().excess(minimum.chi2);
        if (minimum.chi2 < lowest) lowest = minimum.chi2, spread = excess;
        if (distance.dot(curvature * distance) < 0.04 * excess && chi2 - minimum.chi2 < 0.08 * excess) {
          joined = true;
          return ceres::SOLVER_TERMINATE_SUCCESSFULLY;
        }
      }
      if (crawls(summary, chi2, lowest, spread)) {
        abandoned = true;
        return ceres::SOLVER_TERMINATE_SUCCESSFULLY;
      }
    }
    const WholeProblem::Point* point = cost_.known(z);
    if (point && newton_decrement(point->rows.residuals, cost_.free_jacobian(*point)) < options_.decrement)
      return ceres::SOLVER_TERMINATE_SUCCESSFULLY;
    return ceres::SOLVER_CONTINUE;
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

  const MinimiseOptions& options_;
  const WholeProblem& cost_;
  const std::vector<double>& free_;
  int slow_steps_ = 0;
};

}  // namespace

Minimum minimise(const Residuals& residuals, const Eigen::VectorXd& start, const MinimiseOptions& options) {
  WholeProblem cost(residuals, start, options.held);
  if (options.evaluated && options.evaluated->jacobian.rows() > 0) cost.remember(*options.evaluated);
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
  quieten();
  solver.max_num_iterations = options.max_iterations;
  solver.function_tolerance = 1e-15;  // the watch stops earlier
  solver.gradient_tolerance = 1e-14;
  solver.parameter_tolerance = 1e-11;
  // By the wall clock, which may be set from 1970 to today meanwhile.
  solver.max_solver_time_in_seconds = std::numeric_limits<double>::infinity();
  solver.initial_trust_region_radius = 100;
  Watch watch(options, cost, free);
  solver.callbacks.push_back(&watch);
  solver.update_state_every_iteration = true;
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem, &summary);

  minimum.z = cost.full(free.data());
  minimum.chi2 =
      summary.IsSolutionUsable() ? 2 * summary.final_cost : std::numeric_limits<double>::infinity();
  minimum.converged =  // IsSolutionUsable() is true for NO_CONVERGENCE, too
      summary.termination_type == ceres::CONVERGENCE || summary.termination_type == ceres::USER_SUCCESS;
  minimum.joined = watch.joined;
  minimum.abandoned = watch.abandoned;
  if (const WholeProblem::Point* point = cost.known(minimum.z)) {
    minimum.residuals = point->residuals;
    minimum.jacobian = point->jacobian;
  } else if (std::isfinite(minimum.chi2)) {
    residuals.evaluate(residuals.unknowns().values(minimum.z), minimum.residuals, &minimum.jacobian);
  }
  return minimum;
}

KnownMinimum with_curvature(const Residuals& residuals, const Minimum& minimum) {
  KnownMinimum known{minimum, Eigen::MatrixXd::Zero(minimum.z.size(), minimum.z.size())};
  Minimum& at = known.minimum;
  const auto& unknowns = residuals.unknowns();
  if (at.jacobian.rows() == 0 && !residuals.evaluate(unknowns.values(minimum.z), at.residuals, &at.jacobian))
    return known;
  const Eigen::MatrixXd by_z = at.jacobian * unknowns.slopes(minimum.z).asDiagonal();
  known.curvature = by_z.transpose() * by_z;
  return known;
}

namespace {

constexpr Eigen::Index kBlock = 512;  ///< rows: their used columns lie in the cache

/// Of each block, at most.
Eigen::Index kept_of(Eigen::Index columns) {
  return std::min(kBlock, columns + 1);
}

}  // namespace

Eigen::Index compressed_rows(Eigen::Index rows, Eigen::Index columns) {
  return rows <= kBlock ? rows : (rows + kBlock - 1) / kBlock * kept_of(columns);
}

Rows compress(const Eigen::MatrixXd& jacobian, const Eigen::VectorXd& residuals) {
  const Eigen::Index rows = jacobian.rows(), columns = jacobian.cols();
  if (rows <= kBlock) return {jacobian, residuals};
  const Eigen::Index all = compressed_rows(rows, columns);
  Rows result{Eigen::MatrixXd::Zero(all, columns), Eigen::VectorXd::Zero(all)};
  for (Eigen::Index first = 0, next = 0; first < rows; first += kBlock, next += kept_of(columns)) {
    const Eigen::Index n = std::min(kBlock, rows - first);
    std::vector<Eigen::Index> used;
    for (Eigen::Index j = 0; j < columns; ++j)
      if (!jacobian.col(j).segment(first, n).isZero(0)) used.push_back(j);
    const auto width = static_cast<Eigen::Index>(used.size());
    Eigen::MatrixXd block(n, width + 1);
    for (Eigen::Index k = 0; k < width; ++k)
      block.col(k) = jacobian.col(used[static_cast<std::size_t>(k)]).segment(first, n);
    block.col(width) = residuals.segment(first, n);
    const Eigen::Index kept = std::min(n, width + 1);
    const Eigen::MatrixXd triangle = triangle_of(std::move(block));
    for (Eigen::Index k = 0; k < width; ++k)
      result.jacobian.col(used[static_cast<std::size_t>(k)]).segment(next, kept) = triangle.col(k);
    result.residuals.segment(next, kept) = triangle.col(width);
  }
  return result;
}

}  // namespace tribotrack::fit::internal
