#include "fit/internal/next_experiment.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "fit/internal/display.h"
#include "fit/internal/identifiability.h"
#include "fit/internal/parallel.h"
#include "model/trajectory.h"

namespace tribotrack::fit::internal {
namespace {

constexpr int kPhases = 8, kWidths = 7;  ///< grid: phi by pi/4, dtau by pi/4

/// The run whose error is the middle one.
const SummaryRun& typical_run(const Problem& problem) {
  std::vector<const SummaryRun*> runs;
  for (const auto& run : problem.summary_runs) runs.push_back(&run);
  const auto middle = runs.begin() + static_cast<std::ptrdiff_t>(runs.size() / 2);
  std::nth_element(runs.begin(), middle, runs.end(), [](const auto* a, const auto* b) {
    return a->measured.covariance.trace() < b->measured.covariance.trace();
  });
  return **middle;
}

/// Covariance of the reported parameters from the information on all.
Eigen::MatrixXd reported_covariance(const Eigen::MatrixXd& information, Eigen::Index reported) {
  return information.ldlt()
      .solve(Eigen::MatrixXd::Identity(information.rows(), information.cols()))
      .topLeftCorner(reported, reported);
}

double log_determinant(const Eigen::MatrixXd& covariance) {
  const Eigen::LLT<Eigen::MatrixXd> factor(covariance);
  if (factor.info() != Eigen::Success) return std::numeric_limits<double>::infinity();
  return 2 * Eigen::MatrixXd(factor.matrixL()).diagonal().array().log().sum();
}

}  // namespace

std::optional<NextExperiment> next_experiment(const Residuals& residuals, const Eigen::VectorXd& values,
                                              const Eigen::MatrixXd& jacobian, int threads) {
  const auto& unknowns = residuals.unknowns();
  const Problem& problem = unknowns.problem();
  if (problem.summary_runs.empty()) return std::nullopt;
  const Eigen::Index n = unknowns.reported();
  const Eigen::VectorXd units = unknowns.natural_units(values);

  Eigen::MatrixXd information = units.asDiagonal() * (jacobian.transpose() * jacobian) * units.asDiagonal();
  for (Eigen::Index i = 0; i < unknowns.common(); ++i) {
    const double widest = range(unknowns, unknowns.parameter(i), values) / units(i);
    information(i, i) += 1 / (widest * widest);
  }
  const Eigen::MatrixXd now = reported_covariance(information, n);

  SummaryRun base = typical_run(problem);
  const double added = residuals.scatter().between_runs * residuals.scatter().between_runs;
  const double variance = 0.5 * base.measured.covariance.trace() + added;
  struct Candidate {
    double phi, dtau, gain = -1;
    Eigen::MatrixXd covariance;
  };
  std::vector<Candidate> candidates;
  for (int i = 0; i < kPhases; ++i)
    for (int j = 1; j <= kWidths; ++j)
      candidates.push_back({i * std::numbers::pi / 4, j * std::numbers::pi / 4, -1, {}});
  parallel_for(candidates.size(), threads, [&](std::size_t k) {
    Candidate& candidate = candidates[k];
    SummaryRun run = base;
    run.scenario.friction.phase = candidate.phi;
    run.scenario.friction.pulse_width = candidate.dtau;
    if (run.measured.duration > 0) run.scenario.duration = run.measured.duration;
    const auto applied = unknowns.apply(values, run.scenario, run.amplitude_from_track, true);
    if (applied.wanted.empty()) return;
    model::IntegrationOptions options;
    options.derivatives = applied.wanted;
    options.tolerance = 1e-6;  // a forecast
    try {
      const auto end = model::integrate(applied.scenario, options).sensitive_end();
      Eigen::MatrixXd rows = end.position_jacobian * applied.chain / applied.scale;
      if (const auto scale = unknowns.find(FitParameter::scale))
        rows.col(*scale) -= end.sample.position / (applied.scale * applied.scale);
      rows = (rows * units.asDiagonal()).eval() / std::sqrt(variance);
      if (!rows.allFinite()) return;
      candidate.covariance = reported_covariance(information + rows.transpose() * rows, n);
      candidate.gain = log_determinant(now) - log_determinant(candidate.covariance);
    } catch (const std::exception&) {
      candidate.gain = -1;  // the model cannot be evaluated there: no candidate
    }
  });

  const auto best = std::max_element(candidates.begin(), candidates.end(),
                                     [](const auto& a, const auto& b) { return a.gain < b.gain; });
  if (!(best->gain > 0)) return std::nullopt;
  NextExperiment next;
  next.phi = best->phi;
  next.dtau = best->dtau;
  next.sentence = "Film next phi = " + number(next.phi / std::numbers::pi) +
                  " pi, dtau = " + number(next.dtau / std::numbers::pi) +
                  " pi, measured as well as the runs so far:";
  for (Eigen::Index i = 0; i < n; ++i) {
    const FitParameter parameter = unknowns.parameter(i);
    const double before = std::sqrt(now(i, i)) * units(i);
    const double after = std::sqrt(best->covariance(i, i)) * units(i);
    next.predicted_sd[parameter] = after;
    next.sentence += std::string(i > 0 ? ", " : " ") + "sd(" + to_string(parameter) + ") " +
                     number(before * display_factor(parameter), 2) + " -> " +
                     number(after * display_factor(parameter), 2);
  }
  next.sentence += ".";
  return next;
}

}  // namespace tribotrack::fit::internal
