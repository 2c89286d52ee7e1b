#include "fit/design/forecast.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "fit/residuals/end_point.h"
#include "fit/tools/statistics.h"
#include "fit/tools/track_errors.h"
#include "model/trajectory.h"

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
  const Unknowns& unknowns = residuals.unknowns();
  for (const SummaryRun& run : runs)
    most_steps_ = std::max(most_steps_,
                           steps_of(unknowns.apply_summary(values, run, {}).scenario, run.measured.duration));
  if (track_)
    most_steps_ = std::max(
        most_steps_, steps_of(unknowns.apply_trajectory(values, *track_, false).scenario, base_.duration));
  most_steps_ *= kLonger;
  if (track_) return;
  // ln sd = ln sd_ + power ln(length/length_), a straight line through the runs.
  std::vector<double> x, y;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    x.push_back(std::log(std::max(runs[i].measured.vector.norm(), 1e-9)));
    y.push_back(0.5 * std::log(0.5 * residuals.covariance(i).trace()));
  }
  const auto line = line_through<double>(x, y);
  power_ = line.square > 1e-6 ? std::clamp(line.slope, 0.0, 1.0) : 0;
  sd_ = std::exp(line.middle);
  length_ = std::exp(line.mean);
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

void Forecaster::of_displacement(const model::Scenario& scenario, double tolerance,
                                 Forecast& forecast) const {
  const Unknowns& unknowns = residuals_.unknowns();
  const auto applied = unknowns.apply(values_, scenario, amplitude_from_track_, true);
  if (applied.wanted.empty()) return;
  const EndPoint end = end_point(applied.scenario, applied.wanted, tolerance, most_steps_);
  forecast.steps = end.steps;
  const Eigen::Vector2d displacement = end.position / applied.scale;
  Eigen::MatrixXd rows = end.jacobian * applied.chain / applied.scale;
  if (const auto scale = unknowns.find(FitParameter::scale)) rows.col(*scale) -= displacement / applied.scale;
  rows = (rows * units_.asDiagonal()).eval() / std::sqrt(variance(displacement));
  forecast.information = rows.transpose() * rows;
}

void Forecaster::of_track(const model::Scenario& scenario, double tolerance, Forecast& forecast) const {
  const Unknowns& unknowns = residuals_.unknowns();
  const TrajectoryRun& like = unknowns.problem().trajectory_runs[*track_];
  auto applied = unknowns.apply(values_, scenario, amplitude_from_track_, true);
  if (applied.wanted.empty()) return;
  // Its own phase is one more unknown, the last.
  const Eigen::Index wanted = applied.chain.rows(), known = applied.chain.cols();
  applied.wanted.push_back(model::Parameter::start_phase);
  applied.chain.conservativeResize(wanted + 1, known + 1);
  applied.chain.row(wanted).setZero();
  applied.chain.col(known).setZero();
  applied.chain(wanted, known) = 1;

  // Fewer points stand for all that are seen.
  const std::size_t seen = like.track.time.size(), n = std::min(kMostPoints, seen);
  const auto& scatter = residuals_.excess_variance().trajectories[*track_];
  const double white = 0.5 * point_errors(like.track, 0).own.trace() + std::pow(scatter.between_points, 2);
  double all = white * scatter.correlation_time * static_cast<double>(n) / static_cast<double>(seen);
  all += slow_variance(like.track, 0);
  TrajectoryRun run;
  run.scenario = scenario;
  run.track.slow = like.track.slow;
  for (std::size_t k = 0; k < n; ++k)
    run.track.time.push_back(scenario.duration * static_cast<double>(k) / static_cast<double>(n - 1));
  run.track.position.assign(n, Eigen::Vector2d::Zero());
  run.track.covariance.assign(n, all * Eigen::Matrix2d::Identity());
  const PointModel points =
      model_points(unknowns, applied, run.track.time, {!like.track.platform_frame, like.track.exposure},
                   tolerance, true, most_steps_);
  forecast.steps = points.steps;
  const Eigen::MatrixXd rows =
      TrackWhitening(run, 0, {}, residuals_.excess_variance().correlated, residuals_.reference_time())
          .whitened(points.jacobian);
  Eigen::MatrixXd information = rows.transpose() * rows;
  if (like.start_phase_sd > 0) {
    const Eigen::VectorXd by_phase = information.col(known).head(known);
    const double own = information(known, known) + 1 / (like.start_phase_sd * like.start_phase_sd);
    information.topLeftCorner(known, known) -= by_phase * by_phase.transpose() / own;
  }
  forecast.information = units_.asDiagonal() * information.topLeftCorner(known, known) * units_.asDiagonal();
}

Forecast Forecaster::forecast(const Candidate& candidate, double tolerance) const {
  Forecast forecast{candidate, {}};
  try {
    if (track_)
      of_track(scenario(candidate), tolerance, forecast);
    else
      of_displacement(scenario(candidate), tolerance, forecast);
  } catch (const model::InvalidParameter&) {
  } catch (const model::StepLimitExceeded&) {
    forecast.steps = most_steps_;
  }
  if (!forecast.information.allFinite()) forecast.information.resize(0, 0);
  return forecast;
}

}  // namespace tribotrack::fit::internal
