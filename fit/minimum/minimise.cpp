#include "fit/minimum/minimise.h"

#include <ceres/ceres.h>
#include <glog/logging.h>
#include <algorithm>
#include <cmath>
#include <deque>
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
    Linearised at, by_z;  ///< as it is; by z, compressed
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
    for (RowGroup& group : last_->by_z.groups) group = compress(group);
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
    set_num_residuals(static_cast<int>(compressed_rows(rows, shared + own)));
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

namespace {

struct Place {
  Minimum minimum;
  Residuals residuals;  ///< linearised there
};

/// The full model at z; at infinity without a motion.
Place full_at(const Residuals& residuals, const Eigen::VectorXd& z, Residuals::Laws laws) {
  Place place{{}, residuals};
  place.minimum.z = z;
  place.minimum.chi2 = std::numeric_limits<double>::infinity();
  const Eigen::VectorXd values = residuals.unknowns().values(z);
  if (!values.allFinite() || !place.residuals.linearise(values, laws)) return place;
  if (auto at = place.residuals.at(values)) {
    place.minimum.chi2 = at->chi2();
    place.minimum.at = std::move(*at);
  }
  return place;
}

bool lower(const Place& a, const Place& b) {
  return a.minimum.chi2 < b.minimum.chi2;
}

/// Levenberg and Marquardt's method in the full model, with `steps` left to it. False where it ends at a
/// kink.
bool descend(Place& place, const MinimiseOptions& options, Residuals::Laws laws, int& steps) {
  constexpr double kFine = 1e-11, kFirstDamping = 1e-4, kLeastDamping = 1e-6, kMostDamping = 1e3;
  constexpr int kPatience = 5;
  constexpr double kLittle = 1e-3;  ///< of chi^2, in as many steps: at a kink the last digits come slowly
  constexpr double kLeastRatio = 0.3, kMostRatio = 0.98;
  constexpr double kUnseen = 1e-5;  ///< of chi^2: less than the integration's error makes of it
  const double decrement = std::max(options.decrement, kFine);
  const Unknowns& unknowns = place.residuals.unknowns();
  Minimum& best = place.minimum;
  double damping = kFirstDamping, lately = best.chi2;
  Eigen::VectorXd last;  // step
  for (int since = 0; steps > 0 && !best.converged; --steps) {
    const Eigen::MatrixXd jacobian = best.at.scaled(unknowns.slopes(best.z)).jacobian(unknowns.size());
    Eigen::MatrixXd normal = jacobian.transpose() * jacobian;
    const Eigen::VectorXd gradient = jacobian.transpose() * best.at.residuals();
    normal.diagonal() *= 1 + damping;
    Eigen::VectorXd step = -solve_symmetric(normal, gradient);
    const double promised = -step.dot(gradient);
    if (damping <= kFirstDamping && promised < decrement) {
      best.converged = true;
      return true;
    }
    // Steps that follow each other like a geometric series, as where residuals bend, are summed (Aitken).
    const double ratio =
        last.size() > 0 ? (jacobian * step).dot(jacobian * last) / (jacobian * last).squaredNorm() : 0;
    const bool summed = ratio > kLeastRatio && ratio < kMostRatio;
    last = step;
    if (summed) {
      step /= 1 - ratio;
      last.resize(0);
    }
    Place next = full_at(place.residuals, best.z + step, laws);
    const double gain = best.chi2 - next.minimum.chi2;
    if (gain > 0) place = std::move(next);
    // By how far what the linear problem promised was kept (Marquardt; Nielsen 1999).
    if (gain > 0.75 * promised)
      damping = std::max(0.1 * damping, kLeastDamping);
    else if (!(gain > 0.25 * promised) && !summed)
      damping *= gain > 0 ? 3 : 10;
    if (!(gain > 0)) last.resize(0);
    best.converged =
        damping > kMostDamping || (gain > 0 ? gain < decrement : promised < std::max(decrement, kUnseen));
    const bool full_step = damping <= kFirstDamping && gain > 0.25 * promised;
    if (full_step || lately - best.chi2 > kLittle) lately = best.chi2, since = 0;
    if (!best.converged && ++since > kPatience) {
      best.converged = true;
      return false;
    }
  }
  best.converged |= lately - best.chi2 < kNearMinimum;
  return steps > 0;
}

/// The same until the laws add what they do where it ends; `gently`: they are kept meanwhile.
void settle(Place& place, const MinimiseOptions& options, bool gently) {
  constexpr int kMostTimes = 3;
  constexpr double kSettled = 1e-9, kOff = 0.1;  ///< of chi^2
  const Place start = place;
  int steps = options.full_steps;
  for (int k = 0; gently && k < kMostTimes; ++k) {
    const bool smooth = descend(place, options, Residuals::Laws::kept, steps);
    Place there = full_at(place.residuals, place.minimum.z, Residuals::Laws::anew);
    const double off = std::abs(there.minimum.chi2 - place.minimum.chi2);
    there.minimum.converged = place.minimum.converged;
    if (!(off < kOff)) {
      place = lower(there, start) ? there : start;
      break;
    }
    place = std::move(there);
    if (!smooth || newton_decrement(place.minimum.at) < std::max(options.decrement, kSettled)) return;
    if (k + 1 == kMostTimes) return;
    place.minimum.converged = false;
  }
  place.minimum.converged = false;
  steps = options.full_steps;
  descend(place, options, Residuals::Laws::anew, steps);
}

}  // namespace

Minimum minimise_linearised(Residuals& residuals, const Eigen::VectorXd& z, const MinimiseOptions& options) {
  if (!residuals.linear_in_conditions()) return minimise(residuals, z, options);
  constexpr int kMostTimes = 2;
  constexpr double kKept = 0.01, kOff = 0.3;  ///< of chi^2, of what the linear problem promised
  constexpr double kRough = 0.01;
  constexpr double kNear = 1;  ///< sd
  MinimiseOptions rough = options;
  rough.decrement = std::max(options.decrement, kRough);
  rough.max_iterations = 40;
  rough.patient = false;
  // Each minimum of the linear problem is where it is linearised next, lower or not: kinks are stepped over.
  std::vector<Place> places{full_at(residuals, z, Residuals::Laws::anew)};
  bool kept = false, near = false;
  for (int k = 0; k < kMostTimes && !kept; ++k) {
    const Place& from = places.back();
    const Minimum promised =
        minimise(from.minimum.at.empty() ? residuals : from.residuals, from.minimum.z, rough);
    const double one = std::max(1.0, kKept * promised.chi2);
    places.push_back(full_at(residuals, promised.z, Residuals::Laws::anew));
    const double off = std::abs(places.back().minimum.chi2 - promised.chi2);
    near = off < kOff * one;
    kept = off < kKept * one;
    if (places.back().minimum.at.empty()) break;
  }
  std::ranges::stable_sort(places, lower);
  std::erase_if(places, [](const Place& place) { return place.minimum.at.empty(); });
  if (places.empty()) return full_at(residuals, z, Residuals::Laws::anew).minimum;
  Place& best = places.front();
  settle(best, options, near);
  // Where promises are not kept the lowest place need not lead to the lowest minimum.
  if (!kept && options.full_steps == MinimiseOptions{}.full_steps && places.size() > 1 &&
      !(best.minimum.distance(residuals.unknowns(), places[1].minimum.z) < kNear * kNear)) {
    settle(places[1], options, near);
    if (!best.minimum.converged || lower(places[1], best)) std::swap(best, places[1]);
  }
  residuals = best.residuals;
  best.minimum.far_from_linear = !kept;
  return best.minimum;
}

Minimum linearised(const Residuals& residuals, Minimum minimum) {
  if (minimum.at.empty())
    if (auto here = residuals.at(residuals.unknowns().values(minimum.z))) minimum.at = std::move(*here);
  return minimum;
}

}  // namespace tribotrack::fit::internal
