#include "fit/design/forecast.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "fit/residuals/end_point.h"
#include "fit/residuals/point_whitening.h"
#include "fit/tools/dense.h"
#include "fit/tools/track_errors.h"
#include "model/batch.h"
#include "model/parallel.h"

namespace tribotrack::fit::internal {
namespace {

constexpr std::size_t kMostPoints = 240;  ///< of a forecast track: more add no shape
constexpr long kLonger = 50;              ///< times the steps of the runs so far

long steps_of(model::Scenario scenario, double duration) {
  if (duration > 0) scenario.duration = duration;
  return model::integrate(scenario, {.tolerance = 1e-6, .derivatives = {}, .dense = false}).summary().steps;
}

}  // namespace

Forecaster::Forecaster(const Residuals& residuals, const Eigen::VectorXd& values)
    : residuals_(residuals),
      values_(values),
      units_(residuals.unknowns().natural_units(values).head(residuals.unknowns().common())) {
  const Problem& problem = residuals.unknowns().problem();
  const auto& runs = problem.summary_runs;
  const auto driven = [](const TrajectoryRun& run) { return !run.free_slide; };
  const auto& tracks = problem.trajectory_runs;
  const auto first = std::find_if(tracks.begin(), tracks.end(), driven);
  if (std::count_if(tracks.begin(), tracks.end(), driven) > static_cast<std::ptrdiff_t>(runs.size())) {
    track_ = static_cast<std::size_t>(first - tracks.begin());
    base_ = first->scenario;
    base_.duration = first->track.time.back() - first->track.time.front();
    amplitude_from_track_ = first->amplitude_from_track;
  } else {
    base_ = runs.front().scenario;
    amplitude_from_track_ = runs.front().amplitude_from_track;
  }
  clockwise_ = std::sin(base_.drive.phase_shift) >= 0;
  const Unknowns& unknowns = residuals.unknowns();
  for (const SummaryRun& run : runs)
    most_steps_ = std::max(
        most_steps_, steps_of(unknowns.apply_summary(values, run, false).scenario, run.measured.duration));
  if (track_)
    most_steps_ = std::max(
        most_steps_, steps_of(unknowns.apply_trajectory(values, *track_, false).scenario, base_.duration));
  most_steps_ *= kLonger;
  if (track_) return;
  // ln sd = ln sd_ + power ln(length/length_), a straight line through the runs.
  double mean_x = 0, mean_y = 0, square = 0, product = 0;
  std::vector<double> x, y;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    x.push_back(std::log(std::max(runs[i].measured.vector.norm(), 1e-9)));
    y.push_back(0.5 * std::log(0.5 * residuals.covariance(i).trace()));
    mean_x += x.back() / static_cast<double>(runs.size());
    mean_y += y.back() / static_cast<double>(runs.size());
  }
  for (std::size_t i = 0; i < runs.size(); ++i) {
    square += (x[i] - mean_x) * (x[i] - mean_x);
    product += (x[i] - mean_x) * (y[i] - mean_y);
  }
  power_ = square > 1e-6 ? std::clamp(product / square, 0.0, 1.0) : 0;
  sd_ = std::exp(mean_y);
  length_ = std::exp(mean_x);
}

Candidate Forecaster::drive_so_far() const {
  return {base_.friction.phase, base_.friction.pulse_width, base_.drive.amplitude,
          base_.drive.angular_frequency};
}

double Forecaster::variance(const Eigen::Vector2d& displacement) const {
  const double sd = sd_ * std::pow(std::max(displacement.norm(), 0.1 * length_) / length_, power_);
  return sd * sd;
}

model::Scenario Forecaster::scenario(const Candidate& candidate) const {
  model::Scenario scenario = base_;
  scenario.friction.phase = candidate.phi;
  scenario.friction.pulse_width = candidate.dtau;
  const double cycles = base_.end_time() * base_.drive.angular_frequency / (2 * std::numbers::pi);
  scenario.duration =
      (track_ ? cycles : std::round(cycles)) * 2 * std::numbers::pi / candidate.angular_frequency;
  scenario.drive.amplitude_y *= candidate.amplitude / base_.drive.amplitude;
  scenario.drive.amplitude = candidate.amplitude;
  scenario.drive.angular_frequency = candidate.angular_frequency;
  return scenario;
}

Eigen::MatrixXd Forecaster::of_displacement(const model::Scenario& scenario, double tolerance) const {
  const Unknowns& unknowns = residuals_.unknowns();
  const auto applied = unknowns.apply(values_, scenario, amplitude_from_track_, true);
  if (applied.wanted.empty()) return {};
  const EndPoint end = end_point(applied.scenario, applied.wanted, tolerance, most_steps_);
  const Eigen::Vector2d displacement = end.position / applied.scale;
  Eigen::MatrixXd rows = end.jacobian * applied.chain / applied.scale;
  if (const auto scale = unknowns.find(FitParameter::scale)) rows.col(*scale) -= displacement / applied.scale;
  rows = (rows * units_.asDiagonal()).eval() / std::sqrt(variance(displacement));
  return rows.transpose() * rows;
}

Eigen::MatrixXd Forecaster::of_track(const model::Scenario& scenario, double tolerance) const {
  const Unknowns& unknowns = residuals_.unknowns();
  const TrajectoryRun& like = unknowns.problem().trajectory_runs[*track_];
  auto applied = unknowns.apply(values_, scenario, amplitude_from_track_, true);
  if (applied.wanted.empty()) return {};
  // Its own phase is one more unknown, the last.
  const Eigen::Index wanted = applied.chain.rows(), known = applied.chain.cols();
  applied.wanted.push_back(model::Parameter::start_phase);
  applied.chain.conservativeResize(wanted + 1, known + 1);
  applied.chain.row(wanted).setZero();
  applied.chain.col(known).setZero();
  applied.chain(wanted, known) = 1;

  const std::size_t seen = like.track.time.size(), n = std::min(kMostPoints, seen);
  std::vector<double> times;
  for (std::size_t k = 0; k < n; ++k)
    times.push_back(scenario.duration * static_cast<double>(k) / static_cast<double>(n - 1));
  const PointModel points =
      model_points(unknowns, applied, times, {!like.track.platform_frame, like.track.exposure}, tolerance,
                   true, most_steps_);
  const auto& scatter = residuals_.excess_variance().trajectories[*track_];
  const double variance = 0.5 * point_errors(like.track, 0).own.trace() +
                          scatter.between_points * scatter.between_points + kFinestSigma * kFinestSigma;
  // Of one of the n points, which stand for all that are seen.
  const double white =
      variance * scatter.correlation_time * static_cast<double>(n) / static_cast<double>(seen);
  const PointWhitening whitening(times, std::vector<Eigen::Matrix2d>(n, white * Eigen::Matrix2d::Identity()),
                                 std::vector<double>(n, 1), like.track.slow);
  const Eigen::MatrixX2d start = orthonormal(whitening.shift());
  const CorrelatedVariances& variances = residuals_.excess_variance().correlated;
  ErrorParts present{};
  for (std::size_t part = 0; part < kErrorParts; ++part) present[part] = variances[part] > 0;
  const ErrorShapes correlated = error_shapes(times, scenario.drive.angular_frequency, scenario.start_phase,
                                              residuals_.reference_time(), present);
  const Eigen::MatrixXd rows = whitened_columns(points.jacobian, whitening, start);
  const Eigen::MatrixXd errors = whitened_columns(error_columns(correlated), whitening, start) *
                                 column_variances(correlated, variances).cwiseSqrt().asDiagonal();
  Eigen::MatrixXd information = rows.transpose() * rows;
  if (errors.cols() > 0) {
    const Factor factor(Eigen::MatrixXd::Identity(errors.cols(), errors.cols()) +
                        errors.transpose() * errors);
    const Eigen::MatrixXd hidden = factor.whitened(errors.transpose() * rows);
    information -= hidden.transpose() * hidden;
  }
  if (like.start_phase_sd > 0) {
    const Eigen::VectorXd by_phase = information.col(known).head(known);
    const double own = information(known, known) + 1 / (like.start_phase_sd * like.start_phase_sd);
    information.topLeftCorner(known, known) -= by_phase * by_phase.transpose() / own;
  }
  return units_.asDiagonal() * information.topLeftCorner(known, known) * units_.asDiagonal();
}

std::optional<Forecast> Forecaster::forecast(const Candidate& candidate, double tolerance) const {
  Forecast forecast{candidate, {}};
  try {
    forecast.information =
        track_ ? of_track(scenario(candidate), tolerance) : of_displacement(scenario(candidate), tolerance);
  } catch (const model::InvalidParameter&) {
    return std::nullopt;
  } catch (const model::StepLimitExceeded&) {
    return std::nullopt;
  }
  if (forecast.information.size() == 0 || !forecast.information.allFinite()) return std::nullopt;
  return forecast;
}

Forecast Forecaster::turned(const Forecast& forecast, double phi) const {
  Forecast result = forecast;
  result.candidate.phi = phi;
  const Unknowns& unknowns = residuals_.unknowns();
  const auto x = unknowns.find(FitParameter::tilt_x), y = unknowns.find(FitParameter::tilt_y);
  if (!x || !y) return result;
  const double angle = (phi - forecast.candidate.phi) * (clockwise_ ? -1 : 1);
  Eigen::MatrixXd turn = Eigen::MatrixXd::Identity(unknowns.common(), unknowns.common());
  turn(*x, *x) = turn(*y, *y) = std::cos(angle);
  turn(*x, *y) = std::sin(angle);
  turn(*y, *x) = -std::sin(angle);
  result.information = turn.transpose() * forecast.information * turn;
  return result;
}

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
  batch.max_steps = most_steps_;
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
    Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(2, unknowns.common());
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
    if (stage.late()) return;
    all[alone[i]] = forecast(candidates[alone[i]], tolerance);
    stage.done();
  });
  return all;
}

}  // namespace tribotrack::fit::internal
