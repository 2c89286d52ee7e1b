// Driven tracks are searched by what they moved over whole cycles: as many valleys, at a fraction of the
// cost.
#include <algorithm>
#include <limits>
#include <numbers>
#include <optional>

#include "fit/measurement.h"
#include "fit/minimum/multi_start.h"
#include "fit/tools/stage_progress.h"
#include "fit/tools/thresholds.h"

namespace tribotrack::fit::internal {
namespace {

constexpr double kRough = 0.02;  ///< of a displacement

/// As many points of each track as tell where the valleys are.
Problem thinned(Problem problem) {
  constexpr std::size_t kPoints = 200, kATurn = 10;
  for (TrajectoryRun& run : problem.trajectory_runs) {
    TrackTable& track = run.track;
    const double turns = (track.time.back() - track.time.front()) * run.scenario.drive.angular_frequency /
                         (2 * std::numbers::pi);
    const std::size_t wanted = std::max(kPoints, kATurn * static_cast<std::size_t>(turns));
    const std::size_t stride = track.time.size() / wanted;
    if (run.free_slide || stride < 2) continue;
    const auto thin = [&](auto& rows) {
      for (std::size_t k = 0; k * stride < rows.size(); ++k) rows[k] = rows[k * stride];
      rows.resize((rows.size() + stride - 1) / stride);
    };
    thin(track.frame), thin(track.time), thin(track.position), thin(track.covariance);
  }
  return problem;
}

/// Over all its whole turns; nullopt where there is none.
std::optional<Displacement> displacement_of(const TrajectoryRun& run) {
  if (run.free_slide) return std::nullopt;
  try {
    return measure_displacement(run.track, {run.scenario.drive.angular_frequency, 0},
                                std::numeric_limits<int>::max());
  } catch (const DataError&) {
    return std::nullopt;
  }
}

}  // namespace

Problem by_displacements(Problem problem) {
  std::vector<TrajectoryRun> left;
  for (TrajectoryRun& run : problem.trajectory_runs) {
    const auto moved = displacement_of(run);
    if (!moved) {
      left.push_back(std::move(run));
      continue;
    }
    SummaryRun ends{run.name, run.scenario, *moved, run.amplitude_from_track, run.own, run.course};
    if (run.start_phase_sd > 0)
      ends.own.add(model::Parameter::start_phase, run.start_phase_sd * run.start_phase_sd);
    problem.summary_runs.push_back(std::move(ends));
  }
  problem.trajectory_runs = std::move(left);
  return problem;
}

DisplacementSearch search_by_displacements(const Residuals& residuals, const FitOptions& options) {
  const Unknowns& unknowns = residuals.unknowns();
  const Problem ends = by_displacements(unknowns.problem());
  const Unknowns fewer(ends);
  Residuals displacements(fewer, options.threads);
  displacements.set_tolerance(residuals.tolerance());
  displacements.set_own_errors(fewer.first_guess());
  // Good to that share: what single turns tell better leads into valleys that points do not have.
  ExcessVariance rough = displacements.excess_variance();
  rough.runs = kRough * ends.typical_displacement();
  displacements.set_excess_variance(rough);
  Search search = multi_start(displacements, options);
  if (search.minima.empty()) return {search, {}};
  const auto here = [&](const Eigen::VectorXd& z) {  // what all runs share is the same
    Eigen::VectorXd values = unknowns.first_guess();
    values.head(unknowns.common()) = fewer.values(z).head(unknowns.common());
    return unknowns.z(values);
  };
  for (ScreenedPoint& point : search.sample) point.z = here(point.z);
  std::vector<Eigen::VectorXd> places{here(lowest_minimum(displacements, search, options.threads).minimum.z)};
  for (std::size_t i = 1; i < std::min(search.minima.size(), kRefined); ++i)
    if (search.minima[i].chi2 - search.minima[0].chi2 < kNearMinimum)
      places.push_back(here(search.minima[i].z));
  search.minima.clear();
  const Problem sparse = thinned(unknowns.problem());
  const Unknowns of_sparse(sparse);
  Residuals few(of_sparse, options.threads);
  few.set_tolerance(residuals.tolerance());
  few.set_own_errors(of_sparse.first_guess());
  const auto rejected = [&] {
    return std::ranges::none_of(search.minima,
                                [&](const Minimum& m) { return few.p_value(m.chi2) >= kSurprise; });
  };
  Stage stage(options, "tracks", places.size());
  for (std::size_t i = 0; i < places.size() && rejected(); ++i) {
    Residuals there = few;
    if (there.linearise(unknowns.values(places[i])))
      if (Minimum end = minimise_linearised(there, places[i], {.decrement = 1e-3}); !end.at.empty())
        search.minima.push_back(std::move(end));
    stage.done();
  }
  std::ranges::stable_sort(search.minima, [&](const Minimum& a, const Minimum& b) {
    const bool first = admissible(unknowns, a.z), second = admissible(unknowns, b.z);
    return first != second ? first : a.chi2 < b.chi2;
  });
  return {search, places.front()};
}

}  // namespace tribotrack::fit::internal
