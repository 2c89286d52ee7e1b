#include "fit/report/fill_result.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "fit/minimum/multi_start.h"
#include "fit/rounding.h"
#include "fit/tools/dense.h"
#include "fit/tools/parameter_text.h"
#include "fit/tools/parameters.h"
#include "fit/tools/statistics.h"
#include "fit/tools/thresholds.h"
#include "fit/tools/track_errors.h"
#include "fit/uncertainty/identifiability.h"
#include "fit/variances/excess_variance.h"
#include "model/alpha_v.h"
#include "model/trajectory.h"

namespace tribotrack::fit::internal {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kTold = 0.1;  ///< of half an interval's width: a difference not worth telling

}  // namespace

void fill_parameters(const Unknowns& unknowns, const Eigen::VectorXd& values, const Uncertainty& uncertainty,
                     const std::vector<double>& t, FitResult& result) {
  const Eigen::Index n = unknowns.reported();
  auto flat = moved_by_flat_direction(uncertainty);
  if (unknowns.problem().stuck_throughout()) flat.assign(flat.size(), true);  // noise mistaken for motion
  result.covariance = uncertainty.covariance;
  result.correlation = Eigen::MatrixXd::Identity(n, n);
  result.parameters.clear();
  for (Eigen::Index i = 0; i < n; ++i) {
    ParameterEstimate estimate;
    estimate.parameter = unknowns.parameter(i);
    estimate.estimate = values(i);
    estimate.sd =
        flat[static_cast<std::size_t>(i)] ? kInfinity : std::sqrt(std::max(0.0, result.covariance(i, i)));
    estimate.ci95 = estimate.covariance_ci95 =
        interval95(unknowns.transform(i), estimate.parameter, estimate.estimate, estimate.sd,
                   t[static_cast<std::size_t>(i)]);
    estimate.ci95_pieces = {estimate.ci95};
    estimate.profile_ci95 = estimate.bootstrap_ci95 = {std::nan(""), std::nan("")};
    result.parameters.push_back(estimate);
    for (Eigen::Index j = 0; j < n; ++j) {
      const double product = std::sqrt(result.covariance(i, i) * result.covariance(j, j));
      if (i != j && product > 0) result.correlation(i, j) = result.covariance(i, j) / product;
    }
  }
}

void fill_profile(const Profile& profile, double level, ParameterEstimate& estimate) {
  const std::vector<Interval>& pieces = profile.pieces;
  estimate.profile = profile.points;
  estimate.profile_level = level;
  estimate.profile_ci95 = {pieces.front().low, pieces.back().high};
  const Interval& by_covariance = estimate.covariance_ci95;
  const Interval& by_profile = estimate.profile_ci95;
  const auto close = [&](double profile_end, double covariance_end) {
    return std::abs(profile_end - covariance_end) <= kTold * std::abs(covariance_end - estimate.estimate);
  };
  if (pieces.size() == 1 && close(by_profile.low, by_covariance.low) &&
      close(by_profile.high, by_covariance.high))
    return;
  estimate.ci95 = by_profile;
  estimate.ci95_pieces = pieces;
}

namespace {

/// In the piece of every interval in which its estimate lies: the intervals say it already.
bool is_covered(const std::map<FitParameter, double>& values,
                const std::vector<ParameterEstimate>& parameters) {
  return std::ranges::all_of(parameters, [&](const ParameterEstimate& p) {
    const double value = values.at(p.parameter);
    const auto holds = [](const Interval& piece, double x) { return piece.low <= x && x <= piece.high; };
    return std::ranges::any_of(p.ci95_pieces, [&](const Interval& piece) {
      return holds(piece, p.estimate) && holds(piece, value);
    });
  });
}

}  // namespace

void fill_laws(const Unknowns& unknowns, const Eigen::VectorXd& values, const Uncertainty& uncertainty,
               FitResult& result) {
  constexpr int kPlaces = 20;
  constexpr double kSeen = 3;  ///< sds
  const Problem& problem = unknowns.problem();
  bool of_speed = false;
  std::string found;
  for (Eigen::Index i = unknowns.reported(); i < unknowns.common(); ++i) {
    const FitParameter law = unknowns.parameter(i);
    const double sd = std::sqrt(uncertainty.shared(i, i));
    const bool free = problem.sets_free(law);
    if (law < FitParameter::mu2_width || law == FitParameter::stribeck_speed ||
        !(free || std::abs(values(i)) > kSeen * sd))
      continue;
    of_speed |= law == FitParameter::viscous || law == FitParameter::stribeck;
    if (!free)
      found += fmt::format("{}{}, {} = {}", found.empty() ? "" : "; ", facts(law).source, facts(law).name,
                           quoted(values(i), sd));
  }
  if (!found.empty())
    result.warnings.push_back("The data show that friction departs from the paper's law: " + found +
                              ". Values and intervals count it; the curves drawn leave it out.");
  const auto mu1 = unknowns.find(FitParameter::mu1);
  if (!mu1 || !of_speed) return;
  const auto viscous = unknowns.find(FitParameter::viscous), stribeck = unknowns.find(FitParameter::stribeck);
  const auto of_fading = unknowns.find(FitParameter::stribeck_speed);
  const double fading = unknowns.reference_speed() * unknowns.value_of(FitParameter::stribeck_speed, values);
  const double platform = unknowns.reference_amplitude() * unknowns.reference_frequency();
  const double gravity = unknowns.value_of(FitParameter::gravity, values);
  double fastest = platform;
  for (const RunResult& run : result.runs)
    if (const auto speed = run.nuisance.find("initial_speed_mm_s"); speed != run.nuisance.end())
      fastest = std::max(fastest, 1e-3 * speed->second);
  for (int k = 0; k <= kPlaces; ++k) {
    const double speed = k * fastest / kPlaces, ratio = speed / fading;
    const double slow = std::exp(-ratio * ratio);
    Eigen::VectorXd slope = Eigen::VectorXd::Zero(unknowns.common());
    slope(*mu1) = 1 + (stribeck ? values(*stribeck) * slow : 0);
    double mu = values(*mu1) * slope(*mu1);
    if (stribeck) slope(*stribeck) = values(*mu1) * slow;
    if (stribeck && of_fading)
      slope(*of_fading) = values(*mu1) * values(*stribeck) * slow * 2 * ratio * ratio / values(*of_fading);
    if (viscous) {
      slope(*viscous) = speed / gravity;
      mu += values(*viscous) * speed / gravity;
    }
    result.mu_of_speed.push_back({speed, mu, std::sqrt(slope.dot(uncertainty.shared * slope))});
  }
}

void fill_minima(const Residuals& residuals, const std::vector<Minimum>& minima, FitResult& result) {
  const Unknowns& unknowns = residuals.unknowns();
  const double excess = residuals.excess(minima.front().chi2);
  result.minima.emplace_back();
  for (const ParameterEstimate& p : result.parameters) result.minima.front().values[p.parameter] = p.estimate;
  for (std::size_t i = 1; i < minima.size(); ++i) {
    const Minimum& other = minima[i];
    const double above = (other.chi2 - minima.front().chi2) / excess;
    if (above > kNearMinimum) continue;
    const Eigen::VectorXd values = unknowns.values(fold_lag(unknowns, other.z));
    OneMinimum minimum;
    minimum.chi2_above = above;
    std::string list;
    for (Eigen::Index k = 0; k < unknowns.reported(); ++k) {
      const FitParameter parameter = unknowns.parameter(k);
      minimum.values[parameter] = values(k);
      list += fmt::format("{}{} = {}", k > 0 ? ", " : "", to_string(parameter),
                          number(values(k) * display_factor(parameter), 4));
    }
    if (is_covered(minimum.values, result.parameters)) continue;
    minimum.sentence =
        fmt::format("Another minimum fits nearly as well (chi2 higher by {}): {}.", number(above, 2), list);
    result.warnings.push_back(minimum.sentence);
    result.minima.push_back(minimum);
  }
}

namespace {

constexpr const char* kAxes[] = {"dx_mm", "dy_mm"};
constexpr double kOutlyingPoint = 6;  ///< sigma of the other points
constexpr int kMostNamed = 5;

/// `predicted`: the covariance of the model's own displacement.
RunResult summary_result(const Residuals& residuals, const Minimum& best, std::size_t index,
                         const Eigen::Matrix2d& predicted = Eigen::Matrix2d::Zero()) {
  const SummaryRun& run = residuals.unknowns().problem().summary_runs[index];
  const Eigen::VectorXd values = residuals.unknowns().values(best.z);
  const Eigen::Vector2d difference = residuals.difference(best.at, index);
  Displacement measured = run.measured;
  measured.covariance = residuals.covariance(index) + predicted;
  if (!(measured.duration > 0)) measured.duration = run.scenario.end_time();
  derive_alpha_and_v(measured);
  Displacement modelled = measured;
  modelled.vector = measured.vector - difference;

  RunResult result;
  result.name = run.name;
  result.fitted = residuals.unknowns().apply(values, run.scenario, run.amplitude_from_track, false).scenario;
  const Eigen::Vector2d whitened = Factor2(measured.covariance).whitened(difference);
  for (int axis = 0; axis < 2; ++axis)
    result.residuals.push_back({kAxes[axis], 1e3 * measured.vector(axis), 1e3 * modelled.vector(axis),
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

/// Displacement from the first point used to the last, with the noise of both and the correlated errors
/// between.
std::vector<Residual> displacement(const Residuals& residuals, const TrajectoryRun& run, std::size_t index,
                                   const PointResiduals& points) {
  const std::size_t last = points.row.size() - 1;
  const Eigen::Vector2d measured = run.track.position[points.row[last]] - run.track.position[points.row[0]];
  const Eigen::Vector2d modelled = measured - points.residual[last] + points.residual[0];
  const auto& excess = residuals.excess_variance();
  double correlated = 0;
  const ErrorShapes shapes = residuals.track(index).shapes(kAllParts);
  for (std::size_t j = 0; j < shapes.count(); ++j) {
    const auto column = shapes.values.col(static_cast<Eigen::Index>(j));
    correlated += excess.correlated[shapes.part[j]] * std::pow(column(column.size() - 1) - column(0), 2);
  }
  const double between_points = excess.trajectories[index].between_points;
  const Eigen::Matrix2d told = covariance_of_sum(run.track, {{points.row[0], -1}, {points.row[last], 1}});
  std::vector<Residual> result;
  for (int axis = 0; axis < 2; ++axis) {
    const double variance = correlated + told(axis, axis) + 2 * between_points * between_points;
    result.push_back({kAxes[axis], 1e3 * measured(axis), 1e3 * modelled(axis), 1e3 * std::sqrt(variance),
                      (measured(axis) - modelled(axis)) / std::sqrt(variance)});
  }
  return result;
}

void fill_nuisances(const Residuals& residuals, const Eigen::VectorXd& values, std::size_t index,
                    const PointResiduals& points, RunResult& result) {
  const Unknowns& unknowns = residuals.unknowns();
  const TrajectoryRun& run = unknowns.problem().trajectory_runs[index];
  const auto& excess = residuals.excess_variance().trajectories[index];
  auto& nuisance = result.nuisance;
  nuisance["start_x_mm"] = 1e3 * points.start_point.x();
  nuisance["start_y_mm"] = 1e3 * points.start_point.y();
  if (const NuisanceBlock* phase = unknowns.find(Nuisance::phase, index))
    nuisance["start_phase_rad"] = run.scenario.start_phase + values(phase->first);
  nuisance["scatter_mm"] = 1e3 * excess.between_points;
  nuisance["correlation_time_points"] = excess.correlation_time;
  const std::size_t first = points.row.front();
  nuisance["onset_time_s"] = run.track.time[first];
  if (first < run.track.frame.size()) nuisance["onset_frame"] = static_cast<double>(run.track.frame[first]);
  nuisance["end_time_s"] = run.track.time[points.row.back()];
}

/// Of a slide, s from its start; infinite where it gains speed.
double stop_time(model::Scenario slide) {
  const double velocity = slide.initial_velocity.norm();
  const Eigen::Vector2d pull =
      slide.drive.gravity * Eigen::Vector2d(std::sin(slide.drive.tilt_x), std::sin(slide.drive.tilt_y));
  const double along = velocity > 0 ? pull.dot(slide.initial_velocity) / velocity : pull.norm();
  const double deceleration = slide.friction.nominal * slide.drive.gravity - along;
  if (!(deceleration > 0)) return std::numeric_limits<double>::infinity();
  slide.duration = 2 * (velocity + std::abs(slide.spin.rate) * slide.spin.radius) / deceleration;
  if ((slide.spin.rate == 0 && slide.viscous == 0) || !std::isfinite(slide.duration))
    return velocity / deceleration;
  const model::Trajectory run = model::integrate(slide, {.tolerance = 1e-9, .derivatives = {}});
  return run.end_time() - run.summary().stick_time;
}

void fill_slide(const Unknowns& unknowns, const Eigen::VectorXd& values, std::size_t index,
                const PointResiduals& points, RunResult& result) {
  const TrajectoryRun& run = unknowns.problem().trajectory_runs[index];
  auto& nuisance = result.nuisance;
  const Eigen::Vector2d velocity = values.segment<2>(unknowns.find(Nuisance::velocity, index)->first);
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
  result.slide.sentence = fmt::format("Initial speed {:.4g} mm/s; {} points, residual {:.3g} mm rms.",
                                      nuisance["initial_speed_mm_s"], result.points, result.rms_m * 1e3);
  nuisance["stop_time_s"] = run.track.time[points.row.front()] + stop_time(result.fitted);
  if (const NuisanceBlock* deviation = unknowns.find(Nuisance::deviation, index))
    nuisance["mu1"] = unknowns.value_of(FitParameter::mu1, values) + values(deviation->first);
  if (const NuisanceBlock* spin = unknowns.find(Nuisance::spin, index)) {
    nuisance["spin_rad_s"] = values(spin->first);
    nuisance["bearing_over_radius"] = std::exp(values(spin->first + 1));
    nuisance["spin_ratio"] = std::abs(values(spin->first)) * run.track.radius *
                             unknowns.value_of(FitParameter::scale, values) / velocity.norm();
  }
}

/// Counts points far from the model against the median, which a few of them cannot move.
void fill_outlying_points(const TrajectoryRun& run, const PointResiduals& points, RunResult& result,
                          std::vector<std::string>& warnings) {
  std::vector<double> lengths;
  for (const auto& residual : points.residual) lengths.push_back(residual.norm());
  const double sigma = upper_median(lengths) / kRayleighMedian;
  std::string named;
  int count = 0;
  for (std::size_t i = 0; i < lengths.size(); ++i) {
    if (!(lengths[i] > kOutlyingPoint * sigma) || ++count > kMostNamed) continue;
    const std::size_t row = points.row[i];
    const auto frame = row < run.track.frame.size() ? run.track.frame[row] : static_cast<std::int64_t>(row);
    named += fmt::format("{}{}", named.empty() ? "" : ", ", frame);
  }
  result.nuisance["outliers"] = count;
  if (count > 0)
    warnings.push_back(fmt::format(
        "Run '{}': {} points lie beyond 6 sigma of the others (frames {}{}); look at them in the overlay.",
        run.name, count, named, count > kMostNamed ? ", ..." : ""));
}

RunResult trajectory_result(const Residuals& residuals, const Eigen::VectorXd& values, std::size_t index,
                            std::vector<std::string>& warnings) {
  const Unknowns& unknowns = residuals.unknowns();
  const TrajectoryRun& run = unknowns.problem().trajectory_runs[index];
  const PointResiduals points = residuals.points(values, index);
  RunResult result;
  result.name = run.name;
  result.points = points.row.size();
  result.fitted = unknowns.apply_trajectory(values, index, false).scenario;
  const double n = static_cast<double>(points.row.size());
  for (const auto& residual : points.residual) result.rms_m += residual.squaredNorm() / n;
  result.rms_m = std::sqrt(result.rms_m);
  result.residuals = displacement(residuals, run, index, points);
  fill_nuisances(residuals, values, index, points, result);
  if (run.free_slide) fill_slide(unknowns, values, index, points, result);
  fill_outlying_points(run, points, result, warnings);
  return result;
}

}  // namespace

void fill_runs(const Residuals& residuals, const Minimum& best, FitResult& result) {
  const Problem& problem = residuals.unknowns().problem();
  const Eigen::VectorXd values = residuals.unknowns().values(best.z);
  for (std::size_t i = 0; i < problem.summary_runs.size(); ++i)
    result.runs.push_back(summary_result(residuals, best, i));
  for (std::size_t i = 0; i < problem.trajectory_runs.size(); ++i)
    result.runs.push_back(trajectory_result(residuals, values, i, result.warnings));
}

void fill_predictions(const Residuals& residuals, const Minimum& best, const Uncertainty& uncertainty,
                      FitResult& result) {
  const std::vector<SummaryRun>& runs = residuals.unknowns().problem().summary_runs;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    if (!runs[i].held_out) continue;
    const Eigen::Matrix2Xd moved = residuals.derivatives(best.at, i);
    RunResult run = summary_result(residuals, best, i, moved * uncertainty.shared * moved.transpose());
    const double chi2 =
        Eigen::Vector2d(run.residuals[0].standardised, run.residuals[1].standardised).squaredNorm();
    run.prediction = {chi2, chi2_survival(chi2, 2)};
    run.influence = result.runs[i].influence;
    result.runs[i] = std::move(run);
  }
}

namespace {

double sd_of(const CorrelatedVariances& variances, ErrorPart part) {
  return std::sqrt(variances[static_cast<std::size_t>(part)]);
}

/// Rms about the mean of a run; a sine's two coefficients add up to one variance.
double rms_of(const CorrelatedErrors& errors) {
  return std::sqrt(errors.drift * errors.drift / 12 + errors.walk * errors.walk / 6 +
                   errors.circle * errors.circle + 2 * errors.overtones * errors.overtones);
}

}  // namespace

void fill_excess_variance(const Residuals& residuals, bool allowed, FitResult& result) {
  const Problem& problem = residuals.unknowns().problem();
  const ExcessVariance& excess = residuals.excess_variance();
  result.scatter = result.scatter_between_runs = excess.runs;
  for (const auto& run : excess.trajectories) result.scatter = std::max(result.scatter, run.between_points);
  if (!any(excess)) {
    result.covariance_meaning =
        result.loss == Loss::squares
            ? fmt::format(
                  "sd from the data's own sigma (absolute; not scaled by chi2), 95 % intervals with {}",
                  excess.correlated == CorrelatedVariances{} ? "1.96 sd." : "Student's t.")
            : std::string("95 % intervals with Student's t.") + robust_meaning(result.loss);
    if (result.p_value < kSurprise && !allowed)
      result.warnings.push_back(
          fmt::format("chi2 = {} at {} degrees of freedom ({}): the model or the "
                      "sigmas are wrong, and the sds too small.",
                      number(result.chi2, 4), result.dof, chance_text(result.p_value)));
    return;
  }
  const bool repeated = result.scatter_from_replicates;
  result.covariance_meaning = fmt::format(
      "sd from the data's own sigma and a scatter estimated from {}, added in quadrature; 95 % "
      "intervals with Student's t.{}",
      repeated ? "repeated runs" : "the residuals", robust_meaning(result.loss));
  if (repeated)
    result.warnings.push_back(
        fmt::format("Repeated runs scatter by {} mm per axis more than their own sigma; with that the fit "
                    "agrees with all "
                    "runs.",
                    number(1e3 * excess.runs)));
  else if (excess.runs > 0 && result.p_value < kSurprise)
    result.warnings.push_back(fmt::format(
        "The runs scatter by {} mm per axis more than their own sigma (chi2 {}, {}){}something in A, w, tilt "
        "or the model is wrong.",
        number(1e3 * excess.runs), number(result.chi2, 4), chance_text(result.p_value),
        result.replicate_dof >= 6 ? ", and by more than repeated runs do: " : ": real scatter, or "));
  for (std::size_t i = 0; i < excess.trajectories.size(); ++i)
    if (const auto& run = excess.trajectories[i]; run.between_points > 0)
      result.warnings.push_back(
          fmt::format("Run '{}': its points scatter by {} mm per axis more than their own sigma and are "
                      "correlated over {} points; the sd counts both.",
                      problem.trajectory_runs[i].name, number(1e3 * run.between_points),
                      number(run.correlation_time, 2)));
}

void fill_correlated_errors(const Residuals& residuals, FitResult& result) {
  const CorrelatedVariances& variances = residuals.excess_variance().correlated;
  CorrelatedErrors& errors = result.correlated_errors;
  errors.time = residuals.reference_time();
  errors.drift = sd_of(variances, ErrorPart::drift);
  errors.walk = sd_of(variances, ErrorPart::walk);
  errors.circle = sd_of(variances, ErrorPart::circle);
  errors.overtones = sd_of(variances, ErrorPart::overtones);
  if (!errors.any()) return;
  std::string parts;
  const auto add = [&](double size, const std::string& what) {
    if (size > 0) parts += fmt::format("{}{} um {}", parts.empty() ? "" : ", ", number(1e6 * size, 2), what);
  };
  const std::string over = " over " + number(errors.time, 2) + " s";
  add(errors.drift, "of straight drift" + over);
  add(errors.walk, "of Brownian walk" + over);
  add(errors.circle, "at the platform's frequency");
  add(errors.overtones, "at its second and third multiple");
  if (result.p_value < kSurprise) {
    const double rms = rms_of(errors);
    result.scatter = std::max(result.scatter, rms);
    result.warnings.push_back(
        fmt::format("The tracks have correlated errors of {} mm rms per axis beyond their own sigma ({}): "
                    "low-frequency tracking errors, or something in A, w, tilt or the model is wrong.",
                    number(1e3 * rms), chance_text(result.p_value)));
  }
  result.covariance_meaning += fmt::format(
      " It counts correlated errors of the points of a track, independent between runs, "
      "of one size estimated from all tracks by restricted maximum likelihood (sd per axis: "
      "{}); the intervals count its uncertainty (Student's t by Satterthwaite).",
      parts);
}

}  // namespace tribotrack::fit::internal
