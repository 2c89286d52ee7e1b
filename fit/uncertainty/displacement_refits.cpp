#include "fit/uncertainty/displacement_refits.h"

#include <Eigen/Cholesky>
#include <cstddef>

#include "fit/tools/parallel.h"
#include "model/batch.h"

namespace tribotrack::fit::internal {
namespace {

class RefitsInLanes {
 public:
  RefitsInLanes(const Residuals& residuals, const Minimum& best, const CurvedResiduals& curved)
      : best_(best), curved_(curved), unknowns_(residuals.unknowns()) {
    const auto& summary = unknowns_.problem().summary_runs;
    for (std::size_t i = 0; i < summary.size(); ++i) {
      factor_.emplace_back(residuals.covariance(i));
      modelled_.push_back(summary[i].measured.vector - residuals.difference(best.residuals, i));
    }
    values_ = unknowns_.values(best.z);
  }

  std::size_t runs() const { return factor_.size(); }

  /// Where the second order has its minimum; false where it has none.
  bool begin(const Problem& drawn, Eigen::VectorXd& r0, Eigen::VectorXd& t) const {
    r0 = best_.residuals;
    for (std::size_t i = 0; i < runs(); ++i)
      rows(r0, i) = whitened(i, drawn.summary_runs[i].measured.vector - modelled_[i]);
    for (const auto& [parameter, prior] : drawn.prior)
      if (const auto k = unknowns_.find(parameter))
        priors(r0) -=
            best_.jacobian.col(*k).tail(priors(r0).size()) * (prior.mean - unknowns_.prior(*k)->mean);
    const auto minimum = curved_.minimum(r0);
    if (minimum) t = *minimum;
    return minimum.has_value();
  }

  AppliedScenario applied(std::size_t run, const Eigen::VectorXd& t) const {
    return unknowns_.apply_summary(unknowns_.values(curved_.z(t)), unknowns_.problem().summary_runs[run],
                                   false);
  }

  /// The residuals at t with the runs simulated there; none where one could not be.
  std::optional<Eigen::VectorXd> exact(const Problem& drawn, const Eigen::VectorXd& r0,
                                       const Eigen::VectorXd& t, const model::BatchEnd* ends) const {
    Eigen::VectorXd r = r0;
    for (std::size_t i = 0; i < runs(); ++i) {
      if (ends[i].status != model::BatchStatus::done) return std::nullopt;
      const AppliedScenario here = applied(i, t);
      rows(r, i) =
          whitened(i, drawn.summary_runs[i].measured.vector - ends[i].position * (here.stretch / here.scale));
    }
    // Priors are linear in the values.
    const Eigen::VectorXd moved = unknowns_.values(curved_.z(t)) - values_;
    priors(r) += best_.jacobian.bottomRows(priors(r).size()) * moved;
    return r;
  }

 private:
  static Eigen::VectorBlock<Eigen::VectorXd, 2> rows(Eigen::VectorXd& r, std::size_t run) {
    return r.segment<2>(2 * static_cast<Eigen::Index>(run));
  }
  Eigen::VectorBlock<Eigen::VectorXd> priors(Eigen::VectorXd& r) const {
    return r.tail(r.size() - 2 * static_cast<Eigen::Index>(runs()));
  }
  Eigen::Vector2d whitened(std::size_t run, const Eigen::Vector2d& difference) const {
    return factor_[run].matrixL().solve(difference);
  }

  const Minimum& best_;
  const CurvedResiduals& curved_;
  const Unknowns& unknowns_;
  std::vector<Eigen::LLT<Eigen::Matrix2d>> factor_;
  std::vector<Eigen::Vector2d> modelled_;  ///< displacements of the best fit
  Eigen::VectorXd values_;
};

}  // namespace

std::vector<DisplacementRefit> refit_displacements(const Residuals& residuals, const Minimum& best,
                                                   const CurvedResiduals& curved,
                                                   const std::vector<Problem>& drawn, int threads) {
  const RefitsInLanes refits(residuals, best, curved);
  struct Begun {
    bool solved = false;
    Eigen::VectorXd r0, t;
  };
  std::vector<Begun> begun(drawn.size());
  parallel_for(drawn.size(), threads,
               [&](std::size_t k) { begun[k].solved = refits.begin(drawn[k], begun[k].r0, begun[k].t); });
  std::vector<std::size_t> simulated;
  for (std::size_t k = 0; k < begun.size(); ++k)
    if (begun[k].solved) simulated.push_back(k);

  const std::size_t runs = refits.runs();
  model::BatchOptions batch;
  batch.threads = threads;
  batch.tolerance = residuals.tolerance_for(kRefitTolerance, 1e-6);
  const model::BatchOutcome outcome = model::solve_batch(
      simulated.size() * runs,
      [&](std::size_t index) {
        return refits.applied(index % runs, begun[simulated[index / runs]].t).scenario;
      },
      batch);

  std::vector<DisplacementRefit> result(drawn.size(), {best.z, false});
  for (std::size_t i = 0; i < simulated.size(); ++i) {
    const std::size_t k = simulated[i];
    const Begun& b = begun[k];
    const auto exact = refits.exact(drawn[k], b.r0, b.t, &outcome.ends[i * runs]);
    const auto t = exact ? curved.confirmed(b.r0, b.t, *exact) : std::nullopt;
    result[k] = {curved.z(t.value_or(b.t)), t.has_value()};
  }
  return result;
}

}  // namespace tribotrack::fit::internal
