// Forecasts of displacements for many candidates: differences of runs that are solved side by side.
#include <cmath>
#include <cstddef>

#include "fit/design/forecast.h"
#include "model/batch.h"
#include "model/parallel.h"

namespace tribotrack::fit::internal {
namespace {

/// Steps of central differences in natural units, and the tolerance that leaves them good to some 1e-4. A
/// kink nearer than a step (a stop that comes or goes) shows half on each side.
constexpr double kStep = 1e-4, kTolerance = 1e-10;

/// Whether lanes carry it: a circle, and no start from rest next to the threshold of friction. Else exact
/// derivatives are cheaper than differences.
bool for_lanes(const model::Scenario& scenario) {
  const model::Drive& drive = scenario.drive;
  const double length = drive.amplitude * drive.angular_frequency * drive.angular_frequency;
  const auto far = [&](double mu) { return std::abs(mu * drive.gravity - length) > 0.025 * length; };
  return length > 0 && drive.amplitude == drive.amplitude_y && drive.tilt_x == 0 && drive.tilt_y == 0 &&
         std::abs(std::cos(drive.phase_shift)) < 1e-15 && far(scenario.friction.nominal) &&
         far(scenario.friction.reduced);
}

}  // namespace

std::vector<std::optional<Forecast>> Forecaster::forecasts(const std::vector<Candidate>& candidates,
                                                           double tolerance, int threads,
                                                           Stage& stage) const {
  std::vector<std::optional<Forecast>> all(candidates.size());
  const Unknowns& unknowns = residuals_.unknowns();
  const auto applied_at = [&](const Candidate& candidate, const Eigen::VectorXd& values, bool derivatives) {
    return unknowns.apply(values, scenario(candidate), amplitude_from_track_, derivatives);
  };
  const bool tilts = unknowns.find(FitParameter::tilt_x) || unknowns.find(FitParameter::tilt_y);
  std::vector<std::size_t> together, alone;
  for (std::size_t k = 0; k < all.size(); ++k) {
    const bool lanes = !track_ && !tilts && for_lanes(applied_at(candidates[k], values_, false).scenario);
    (lanes ? together : alone).push_back(k);
  }
  stage.expect(candidates.size());
  // Of each candidate the run itself, then one to either side for every unknown.
  const auto columns = static_cast<std::size_t>(unknowns.common()), runs = 1 + 2 * columns;
  const auto applied_to = [&](std::size_t index) {
    Eigen::VectorXd values = values_;
    if (const std::size_t run = index % runs; run > 0) {
      const auto u = static_cast<Eigen::Index>((run - 1) / 2);
      values(u) += (run % 2 == 1 ? kStep : -kStep) * units_(u);
    }
    return applied_at(candidates[together[index / runs]], values, false);
  };
  model::BatchOptions batch;
  batch.threads = threads;
  batch.tolerance = kTolerance;
  const model::BatchOutcome outcome = model::solve_batch(
      together.size() * runs, [&](std::size_t index) { return applied_to(index).scenario; }, batch);
  for (std::size_t k = 0; k < together.size(); ++k) {
    const Candidate& candidate = candidates[together[k]];
    bool solved = !applied_at(candidate, values_, true).wanted.empty();
    const auto displacement = [&](std::size_t run) -> Eigen::Vector2d {
      const model::BatchEnd& end = outcome.ends[k * runs + run];
      solved = solved && end.status == model::BatchStatus::done;
      return end.position / applied_to(k * runs + run).scale;
    };
    Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(2, unknowns.size());
    for (std::size_t u = 0; u < columns; ++u)
      rows.col(static_cast<Eigen::Index>(u)) =
          (displacement(1 + 2 * u) - displacement(2 + 2 * u)) / (2 * kStep);
    rows /= std::sqrt(variance(displacement(0)));
    if (solved) {
      all[together[k]] = Forecast{candidate, rows.transpose() * rows};
      stage.done();
    } else {
      alone.push_back(together[k]);  // a step can leave the model's range where mu2 is nearly 0
    }
  }
  parallel_for(alone.size(), threads, [&](std::size_t i) {
    all[alone[i]] = forecast(candidates[alone[i]], tolerance);
    stage.done();
  });
  return all;
}

}  // namespace tribotrack::fit::internal
