#include "fit/report/fill_result.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "fit/residuals/sticking.h"
#include "fit/tools/parameter_text.h"
#include "fit/uncertainty/identifiability.h"
#include "model/alpha_v.h"

namespace tribotrack::fit::internal {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

RunResult tell_summary(const Residuals& residuals, const Minimum& best, std::size_t index) {
  const SummaryRun& run = residuals.unknowns().problem().summary_runs[index];
  const Eigen::VectorXd values = residuals.unknowns().values(best.z);
  const Eigen::Vector2d difference = residuals.difference(best.residuals, index);
  Displacement measured = run.measured;
  measured.covariance = residuals.covariance(index);
  if (!(measured.duration > 0)) measured.duration = run.scenario.end_time();
  derive_alpha_and_v(measured);
  Displacement modelled = measured;
  modelled.vector = measured.vector - difference;

  RunResult result;
  result.name = run.name;
  result.fitted = residuals.unknowns().apply(values, run.scenario, run.amplitude_from_track, false).scenario;
  const Eigen::LLT<Eigen::Matrix2d> factor(measured.covariance);
  const Eigen::Vector2d whitened = factor.matrixL().solve(difference);
  const char* names[] = {"dx_mm", "dy_mm"};
  for (int axis = 0; axis < 2; ++axis)
    result.residuals.push_back({names[axis], 1e3 * measured.vector(axis), 1e3 * modelled.vector(axis),
                                1e3 * std::sqrt(measured.covariance(axis, axis)), whitened(axis)});
  if (measured.alpha && modelled.vector.norm() > 0) {
    const double alpha = model::displacement_angle(modelled.vector);
    result.residuals.push_back({"alpha_rad", measured.alpha->value, alpha, measured.alpha->sd,
                                model::wrap_angle(measured.alpha->value - alpha) / measured.alpha->sd});
  }
  const double v = modelled.vector.norm() / measured.duration;
  result.residuals.push_back({"v_mm_s", 1e3 * measured.mean_velocity.value, 1e3 * v,
                              1e3 * measured.mean_velocity.sd,
                              (measured.mean_velocity.value - v) / measured.mean_velocity.sd});
  return result;
}

RunResult tell_trajectory(const Residuals& residuals, const Eigen::VectorXd& values, std::size_t index,
                          FitResult& fit) {
  const Unknowns& unknowns = residuals.unknowns();
  const TrajectoryRun& run = unknowns.problem().trajectory_runs[index];
  const PointResiduals points = residuals.points(values, index);
  const auto& scatter = residuals.scatter().trajectories[index];
  const double n = static_cast<double>(points.row.size());

  RunResult result;
  result.name = run.name;
  result.points = points.row.size();
  result.fitted = run.free_slide ? unknowns.apply_free_slide(values, index, false).scenario
                                 : unknowns.apply_trajectory(values, index, false).scenario;
  std::vector<double> lengths;
  for (const auto& residual : points.residual) {
    result.rms_m += residual.squaredNorm() / n;
    lengths.push_back(residual.norm());
  }
  result.rms_m = std::sqrt(result.rms_m);
  const std::size_t last = points.row.size() - 1;
  const Eigen::Vector2d measured = run.track.position[points.row[last]] - run.track.position[points.row[0]];
  const Eigen::Vector2d modelled = measured - points.residual[last] + points.residual[0];
  double slow = 0;
  const SlowShapes shapes = residuals.shapes(index, kAllSlowParts);
  for (std::size_t j = 0; j < shapes.count(); ++j) {
    const auto column = shapes.values.col(static_cast<Eigen::Index>(j));
    slow += residuals.scatter().slow[shapes.part[j]] * std::pow(column(column.size() - 1) - column(0), 2);
  }
  const char* names[] = {"dx_mm", "dy_mm"};
  for (int axis = 0; axis < 2; ++axis) {
    const double variance = slow + run.track.covariance[points.row[last]](axis, axis) +
                            run.track.covariance[points.row[0]](axis, axis) +
                            2 * scatter.between_points * scatter.between_points;
    result.residuals.push_back({names[axis], 1e3 * measured(axis), 1e3 * modelled(axis),
                                1e3 * std::sqrt(variance),
                                (measured(axis) - modelled(axis)) / std::sqrt(variance)});
  }

  auto& nuisance = result.nuisance;
  nuisance["start_x_mm"] = 1e3 * points.start_point.x();
  nuisance["start_y_mm"] = 1e3 * points.start_point.y();
  if (const Eigen::Index phase = unknowns.phase_index(index); phase >= 0)
    nuisance["start_phase_rad"] = run.scenario.start_phase + values(phase);
  nuisance["scatter_mm"] = 1e3 * scatter.between_points;
  nuisance["correlation_time_points"] = scatter.correlation_time;
  const std::size_t first = points.row.front();
  nuisance["onset_time_s"] = run.track.time[first];
  if (first < run.track.frame.size()) nuisance["onset_frame"] = static_cast<double>(run.track.frame[first]);
  nuisance["end_time_s"] = run.track.time[points.row.back()];
  if (run.free_slide) {
    const Eigen::Vector2d velocity = values.segment<2>(unknowns.velocity_index(index));
    nuisance["velocity_x_mm_s"] = 1e3 * velocity.x();
    nuisance["velocity_y_mm_s"] = 1e3 * velocity.y();
    nuisance["initial_speed_mm_s"] = 1e3 * velocity.norm();
    const Eigen::Vector2d along = velocity.normalized();
    for (std::size_t i = 0; i < points.row.size(); ++i) {
      const double measured_along = along.dot(run.track.position[points.row[i]] - points.start_point);
      result.slide.time.push_back(run.track.time[points.row[i]]);
      result.slide.measured.push_back(measured_along);
      result.slide.modelled.push_back(measured_along - along.dot(points.residual[i]));
    }
    const double mu1 = unknowns.value_of(FitParameter::mu1, values);
    nuisance["stop_time_s"] = run.track.time[first] + velocity.norm() / (mu1 * run.scenario.drive.gravity);
  }

  // Outliers against the middle of the residuals, which a few of them cannot move.
  std::vector<double> sorted = lengths;
  std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2),
                   sorted.end());
  const double middle = sorted[sorted.size() / 2] / 1.1774;  // median of a Rayleigh variable, sigma = 1
  std::string named;
  int count = 0;
  for (std::size_t i = 0; i < lengths.size(); ++i) {
    if (!(lengths[i] > 6 * middle)) continue;
    if (++count <= 5) {
      const std::size_t row = points.row[i];
      named += (named.empty() ? "" : ", ") +
               std::to_string(row < run.track.frame.size() ? run.track.frame[row] : static_cast<long>(row));
    }
  }
  nuisance["outliers"] = count;
  if (count > 0)
    fit.warnings.push_back("Run '" + run.name + "': " + std::to_string(count) +
                           " points lie beyond 6 sigma of the others (frames " + named +
                           (count > 5 ? ", ..." : "") + "); look at them in the overlay.");
  return result;
}

}  // namespace

Interval interval95(const Transform& transform, FitParameter parameter, double value, double sd, double t) {
  if (!std::isfinite(sd)) return {transform.positive() ? 0 : -kInfinity, kInfinity};
  const bool on_logarithm = transform.positive() && value > 0 && sd < 0.3 * value;
  if (on_logarithm) return {value * std::exp(-t * sd / value), value * std::exp(t * sd / value)};
  const double low = value - t * sd;
  const bool cut = parameter == FitParameter::mu1 || parameter == FitParameter::mu2;
  return {cut ? std::max(0.0, low) : low, value + t * sd};
}

void tell_parameters(const Unknowns& unknowns, const Eigen::VectorXd& values, const Uncertainty& uncertainty,
                     const std::vector<double>& t, FitResult& result) {
  const Eigen::Index n = unknowns.reported();
  auto flat = moved_by_flat_direction(uncertainty);
  if (stuck_throughout(unknowns.problem())) flat.assign(flat.size(), true);  // noise told as motion
  result.covariance = uncertainty.covariance;
  result.correlation = Eigen::MatrixXd::Identity(n, n);
  result.parameters.clear();
  for (Eigen::Index i = 0; i < n; ++i) {
    ParameterEstimate estimate;
    estimate.parameter = unknowns.parameter(i);
    estimate.estimate = values(i);
    estimate.sd =
        flat[static_cast<std::size_t>(i)] ? kInfinity : std::sqrt(std::max(0.0, result.covariance(i, i)));
    estimate.ci95 = interval95(unknowns.transform(i), estimate.parameter, estimate.estimate, estimate.sd,
                               t[static_cast<std::size_t>(i)]);
    estimate.profile_ci95 = estimate.bootstrap_ci95 = {std::nan(""), std::nan("")};
    result.parameters.push_back(estimate);
    for (Eigen::Index j = 0; j < n; ++j) {
      const double product = std::sqrt(result.covariance(i, i) * result.covariance(j, j));
      if (i != j && product > 0) result.correlation(i, j) = result.covariance(i, j) / product;
    }
  }
}

void tell_runs(const Residuals& residuals, const Minimum& best, FitResult& result) {
  const Problem& problem = residuals.unknowns().problem();
  const Eigen::VectorXd values = residuals.unknowns().values(best.z);
  for (std::size_t i = 0; i < problem.summary_runs.size(); ++i)
    result.runs.push_back(tell_summary(residuals, best, i));
  for (std::size_t i = 0; i < problem.trajectory_runs.size(); ++i)
    result.runs.push_back(tell_trajectory(residuals, values, i, result));
}

void tell_systematics(const Residuals& residuals, const Minimum& best, const Uncertainty& uncertainty,
                      FitResult& result) {
  const Unknowns& unknowns = residuals.unknowns();
  if (unknowns.reference_amplitude() <= 0 || uncertainty.rank < unknowns.reported()) return;
  const Eigen::VectorXd values = unknowns.values(best.z);
  // Refit to first order after a change of 1 % in A or w: -(J'J)^-1 J' dr.
  constexpr double kChange = 2e-3, kTolerance = 1e-7;
  const auto shift_by = [&](FitParameter parameter) -> std::optional<Eigen::VectorXd> {
    const auto moved_residuals = [&](double change) -> std::optional<Eigen::VectorXd> {
      Problem moved = unknowns.problem();
      moved.fixed[parameter] = unknowns.value_of(parameter, values) * (1 + change);
      if (parameter ==
          FitParameter::angular_frequency)  // whole cycles end earlier, at the same mean velocity
        for (auto& run : moved.summary_runs) {
          if (run.measured.told_as_velocity) continue;  // followed by the model itself
          run.measured.duration /= 1 + change;
          run.measured.vector /= 1 + change;
        }
      const Unknowns moved_unknowns(moved);
      Residuals whitened(moved, moved_unknowns);
      whitened.set_scatter(residuals.scatter());
      whitened.set_weights(residuals.weights());
      whitened.set_tolerance(kTolerance);
      Eigen::VectorXd r;
      if (!whitened.evaluate(values, r, nullptr)) return std::nullopt;
      return r;
    };
    const auto r = moved_residuals(kChange);
    if (!r) return std::nullopt;
    return Eigen::VectorXd(-uncertainty.full_covariance *
                           (best.jacobian.transpose() * (*r - best.residuals)) * (0.01 / kChange));
  };
  const auto tell = [&](FitParameter parameter, const char* name) {
    if (unknowns.find(parameter)) return;
    const auto shift = shift_by(parameter);
    if (!shift) return;
    std::string text = std::string(name) + " up 1 %: ";
    for (Eigen::Index i = 0; i < unknowns.reported(); ++i)
      text += (i > 0 ? ", " : "") + change_in_words(unknowns.parameter(i), (*shift)(i), values(i));
    result.systematics.push_back(text + ".");
  };
  tell(FitParameter::amplitude, "A");
  tell(FitParameter::angular_frequency, "w");
}

}  // namespace tribotrack::fit::internal
