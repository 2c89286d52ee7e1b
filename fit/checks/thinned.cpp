#include "fit/checks/thinned.h"

#include <algorithm>

namespace tribotrack::fit::internal {
namespace {

constexpr std::size_t kMostPoints = 150;

std::size_t every_of(const TrajectoryRun& run) {
  return run.free_slide ? 1 : (run.track.time.size() + kMostPoints - 1) / kMostPoints;
}

void thin(TrackTable& track, std::size_t every) {
  const std::size_t n = track.time.size();
  TrackTable few;
  few.platform_frame = track.platform_frame;
  few.radius = track.radius;
  few.slow = track.slow;
  for (std::size_t i = 0; i < n; i += every) {
    if (i < track.frame.size()) few.frame.push_back(track.frame[i]);
    few.time.push_back(track.time[i]);
    few.position.push_back(track.position[i]);
    few.covariance.push_back(track.covariance[i]);
    if (!track.shared.empty()) few.shared.push_back(track.shared[i]);
  }
  track = few;
}

Problem thinned(const Unknowns& unknowns, const Eigen::VectorXd& values) {
  Problem problem = unknowns.problem();
  for (std::size_t i = 0; i < problem.trajectory_runs.size(); ++i) {
    TrajectoryRun& run = problem.trajectory_runs[i];
    run.track.exposure = 0;
    if (const Eigen::Index phase = unknowns.phase_index(i); phase >= 0)
      run.scenario.start_phase += values(phase);
    run.start_phase_sd = 0;
    if (const Eigen::Index own = unknowns.own_index(i); own >= 0)
      for (std::size_t k = 0; k < run.own.parameters.size(); ++k)
        run.scenario.set(run.own.parameters[k], run.scenario.get(run.own.parameters[k]) +
                                                    values(own + static_cast<Eigen::Index>(k)));
    run.own = {};
    thin(run.track, every_of(run));
  }
  return problem;
}

}  // namespace

Thinned::Thinned(const Residuals& residuals, const Minimum& best)
    : problem_(thinned(residuals.unknowns(), residuals.unknowns().values(best.z))),
      unknowns_(problem_),
      residuals_(unknowns_) {
  residuals_.set_tolerance(1e-8);
  // Scatter between points was estimated under the paper's law and would hide what that law misses.
  ExcessVariance scatter = residuals_.excess_variance();
  scatter.correlated = residuals.excess_variance().correlated;
  residuals_.set_excess_variance(scatter);
  // The phases and own errors came last.
  best_ = minimise(residuals_, best.z.head(unknowns_.size()), {.held = {}, .decrement = 1e-6});
}

}  // namespace tribotrack::fit::internal
