#include "fit/slips.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <numbers>
#include <optional>

#include "fit/minimum/minimise.h"
#include "fit/minimum/multi_start.h"
#include "fit/minimum/screen.h"
#include "fit/residuals/residuals.h"
#include "fit/tools/statistics.h"
#include "fit/tools/thresholds.h"

namespace tribotrack::fit {

using namespace internal;

namespace {

constexpr double kLeastMu1 = 0.005, kLargestMu1 = 0.6;
/// mu of dry pairs, from which slips are judged that describe the data alike.
constexpr double kUsualMu1 = 0.2;
constexpr double kPi = std::numbers::pi;

double known(const Problem& problem, const std::map<FitParameter, double>& values, FitParameter parameter) {
  if (const auto found = values.find(parameter); found != values.end()) return found->second;
  const auto fixed = problem.fixed.find(parameter);
  return fixed == problem.fixed.end() ? 0 : fixed->second;
}

/// Conditions and prior in proportion to a quantity.
void rescale(Problem& problem, FitParameter quantity, double factor) {
  for (Condition& condition : problem.conditions)
    if (condition.quantity == quantity) condition.sd *= factor;
  if (const auto prior = problem.prior.find(quantity); prior != problem.prior.end())
    prior->second = {prior->second.mean * factor, prior->second.sd * factor};
}

void scale_amplitude(Problem& problem, double factor) {
  for (SummaryRun& run : problem.summary_runs) {
    run.scenario.drive.amplitude *= factor;
    run.scenario.drive.amplitude_y *= factor;
  }
  rescale(problem, FitParameter::amplitude, factor);
}

void scale_displacement(SummaryRun& run, double factor) {
  run.measured.vector *= factor;
  run.measured.covariance *= factor * factor;
}

/// A velocity was measured over cycles that are shorter by the factor.
void scale_frequency(Problem& problem, double factor) {
  for (SummaryRun& run : problem.summary_runs) {
    run.scenario.drive.angular_frequency *= factor;
    if (!run.measured.given_as_velocity) continue;
    scale_displacement(run, 1 / factor);
    run.measured.duration /= factor;
  }
  rescale(problem, FitParameter::angular_frequency, factor);
}

void scale_lengths(Problem& problem, double factor) {
  bool amplitude = false;
  for (SummaryRun& run : problem.summary_runs) {
    if (run.measured.given_as_velocity) continue;
    scale_displacement(run, factor);
    if (!run.amplitude_from_track) continue;
    amplitude = true;
    run.scenario.drive.amplitude *= factor;
    run.scenario.drive.amplitude_y *= factor;
  }
  if (amplitude) rescale(problem, FitParameter::amplitude, factor);
}

/// Turns a displacement, as `map` does the plane.
void map_displacement(SummaryRun& run, const Eigen::Matrix2d& map) {
  run.measured.vector = map * run.measured.vector;
  run.measured.covariance = map * run.measured.covariance * map.transpose();
}

void scale_alpha(SummaryRun& run, double factor) {
  const double alpha = std::atan2(run.measured.vector.y(), run.measured.vector.x());
  map_displacement(run, Eigen::Rotation2Dd((factor - 1) * alpha).toRotationMatrix());
}

struct Candidate {
  SlipFound::What what;
  double factor;
  std::function<void(Problem&)> undo;
};

/// Factors of what was typed.
std::vector<Candidate> magnitudes(const Typed& typed) {
  using enum SlipFound::What;
  std::vector<Candidate> list;
  const auto add = [&](SlipFound::What what, double factor, auto undo) {
    list.push_back({what, factor, std::move(undo)});
  };
  if (typed.amplitude)  // the usual one first
    for (const double f : {0.5, 2.0, 10.0, 0.1, 1e3, 1e-3})
      add(amplitude, f, [f](Problem& problem) { scale_amplitude(problem, f); });
  if (typed.frequency)
    for (const double f : {2 * kPi, 1 / (2 * kPi)})
      add(frequency, f, [f](Problem& problem) { scale_frequency(problem, f); });
  if (typed.lengths)
    for (const double f : {0.1, 10.0, 0.5, 2.0})
      add(lengths, f, [f](Problem& problem) { scale_lengths(problem, f); });
  return list;
}

/// Units and turns of angles.
std::vector<Candidate> turns(const Typed& typed, const Problem& given) {
  using enum SlipFound::What;
  std::vector<Candidate> list;
  const auto add = [&](SlipFound::What what, double factor, auto change) {
    list.push_back({what, factor, [change](Problem& problem) {
                      for (SummaryRun& run : problem.summary_runs) change(run);
                    }});
  };
  const auto add_angles = [&](SlipFound::What what, double f, double of_phi, double of_dtau,
                              double of_alpha) {
    add(what, f, [=](SummaryRun& run) {
      run.scenario.friction.phase *= of_phi;
      run.scenario.friction.pulse_width *= of_dtau;
      scale_alpha(run, of_alpha);
    });
  };
  for (const double f : {180 / kPi, kPi / 180}) {
    if (typed.timing) {
      add_angles(phi, f, f, 1, 1);
      add_angles(dtau, f, 1, f, 1);
      add_angles(timing, f, f, f, 1);
    }
    if (typed.directions) add_angles(alpha, f, 1, 1, f);
    if (typed.timing && typed.directions) add_angles(angles, f, f, f, f);
  }
  add(alpha_mirrored, -1,
      [](SummaryRun& run) { map_displacement(run, Eigen::Vector2d(1, -1).asDiagonal().toDenseMatrix()); });
  const bool lag_is_fitted = given.fits(FitParameter::lag);
  if (typed.timing && !lag_is_fitted)  // else it is the lag
    for (const double f : {kPi / 2, kPi, -kPi / 2})
      add(phi_turned, f, [f](SummaryRun& run) { run.scenario.friction.phase += f; });
  const auto counted = [](double sense, double share) {
    return [=](SummaryRun& run) {
      model::Friction& friction = run.scenario.friction;
      friction.phase = sense * friction.phase + share * friction.pulse_width;
    };
  };
  const auto [narrowest, widest] = std::ranges::minmax_element(
      given.summary_runs, {}, [](const SummaryRun& run) { return run.scenario.friction.pulse_width; });
  const bool one_width =
      widest->scenario.friction.pulse_width - narrowest->scenario.friction.pulse_width < 1e-6;
  const bool edges_are_lag = one_width && lag_is_fitted;
  if (typed.timing) add(phi_reversed, -1, counted(-1, -1));
  if (typed.timing && !edges_are_lag) {
    for (const double share : {0.0, -0.5}) add(phi_reversed, share, counted(-1, share));
    for (const double share : {-0.5, -1.0}) add(phi_edge, share, counted(1, share));
  }
  return list;
}

bool within_bounds(const Problem& problem) {
  return std::ranges::all_of(problem.summary_runs, [](const SummaryRun& run) {
    return run.scenario.friction.pulse_width <= 2 * kPi * (1 + 1e-6);
  });
}

/// The best place for each lag, of friction below what the drive slides and beyond it, where the part rests
/// between pulses: no descent leads across. Best first.
std::vector<Eigen::VectorXd> places_around(const Residuals& residuals) {
  constexpr int kLags = 8;
  const Unknowns& unknowns = residuals.unknowns();
  const double threshold = unknowns.sliding_threshold().value_or(kUsualMu1);
  const auto mu1 = unknowns.find(FitParameter::mu1), mu2 = unknowns.find(FitParameter::mu2),
             lag = unknowns.find(FitParameter::lag);
  std::map<double, Eigen::VectorXd> best;  // by chi^2
  for (int k = 0; k < (lag ? kLags : 1); ++k)
    for (const auto& shares : {std::vector{0.25, 0.5, 0.9}, {1.1, 1.3}}) {
      std::map<double, Eigen::VectorXd> here;
      for (const double share : shares)
        for (const double ratio : {0.1, 0.4, 0.7}) {
          Eigen::VectorXd values = unknowns.first_guess();
          if (mu1) values(*mu1) = share * threshold;
          if (mu2) values(*mu2) = ratio * unknowns.value_of(FitParameter::mu1, values);
          if (lag) values(*lag) = 2 * kPi * k / kLags;
          here.emplace(residuals.chi2(values), values);
        }
      best.insert(*here.begin());
    }
  std::vector<Eigen::VectorXd> places;
  for (const auto& [chi2, values] : best) places.push_back(values);
  return places;
}

/// Where the data of a problem lie near the model, to some per cent and with its conditions as given; nothing
/// where they do not.
std::optional<Eigen::VectorXd> roughly(Problem problem) {
  constexpr double kNear = 0.05;            // of a typical displacement
  constexpr double kFar = 1, kStray = 100;  // chi^2/dof: of a few per cent, of half a displacement
  constexpr std::size_t kLookedAt = 16, kDescents = 6;
  problem.conditions.clear();
  keep_representative(problem.summary_runs, kLookedAt);
  std::vector<double> lengths;
  for (const SummaryRun& run : problem.summary_runs) lengths.push_back(run.measured.vector.norm());
  const Unknowns unknowns(problem);
  Residuals residuals(unknowns);
  residuals.set_tolerance(1e-4);
  ExcessVariance excess;
  excess.runs = kNear * upper_median(lengths);
  residuals.set_excess_variance(excess);
  const double dof = std::max(1.0, residuals.degrees_of_freedom());
  std::vector<Eigen::VectorXd> places = places_around(residuals);
  places.resize(std::min(kDescents, places.size()));
  for (const Eigen::VectorXd& place : places) {
    if (!(residuals.chi2(place) < kStray * dof)) break;
    const Minimum minimum = minimise(residuals, unknowns.z(place), {.decrement = 0.1, .max_iterations = 12});
    if (minimum.chi2 < kFar * dof) return unknowns.values(minimum.z);
  }
  return std::nullopt;
}

/// The fit with a slip undone; nothing where that is no better.
std::optional<SlipFound> refit(const Problem& problem, const Candidate& candidate) {
  const std::optional<Eigen::VectorXd> near = roughly(problem);
  if (!near) return std::nullopt;
  const Unknowns unknowns(problem);
  Residuals residuals(unknowns);
  residuals.set_tolerance(1e-5);
  Eigen::VectorXd values = unknowns.first_guess();
  values.head(near->size()) = *near;
  residuals.set_own_errors(values);
  const Minimum minimum = minimise(residuals, unknowns.z(values), {.decrement = 0.01, .max_iterations = 25});
  SlipFound slip{candidate.what, candidate.factor, {}, minimum.chi2, 0, 0};
  slip.dof = std::max(0, static_cast<int>(std::lround(residuals.degrees_of_freedom())));
  slip.p_value = chi2_survival(minimum.chi2, residuals.degrees_of_freedom());
  values = unknowns.values(fold_lag(unknowns, minimum.z));
  for (std::size_t i = 0; i < problem.free.size(); ++i)
    slip.values[problem.free[i]] = values(static_cast<Eigen::Index>(i));
  return slip;
}

bool plausible(const Problem& problem, const std::map<FitParameter, double>& values) {
  const double mu1 = known(problem, values, FitParameter::mu1),
               mu2 = known(problem, values, FitParameter::mu2);
  return mu1 >= kLeastMu1 && mu1 <= kLargestMu1 && mu2 <= mu1;
}

/// Does everything measured scale with the length? Then friction does, and nothing else changes.
bool all_scale(const Problem& problem) {
  const auto scales = [](const SummaryRun& run) {
    return run.amplitude_from_track && !run.measured.given_as_velocity;
  };
  return std::ranges::all_of(problem.summary_runs, scales) &&
         std::ranges::all_of(problem.trajectory_runs,
                             [](const TrajectoryRun& r) { return r.free_slide || r.amplitude_from_track; });
}

SlipFound scaled(const FitResult& result, double factor) {
  SlipFound slip{SlipFound::What::lengths, factor, {}, result.chi2, result.dof, result.p_value};
  for (const ParameterEstimate& p : result.parameters)
    slip.values[p.parameter] =
        p.estimate * (p.parameter == FitParameter::mu1 || p.parameter == FitParameter::mu2 ? factor : 1);
  return slip;
}

}  // namespace

bool is_failing(const FitResult& result) {
  return !result.converged || result.scatter_dominates || result.p_value < kSurprise;
}

bool is_absurd(const FitResult& result) {
  double mu1 = kUsualMu1, mu2 = 0;
  for (const ParameterEstimate& p : result.parameters) {
    if (p.parameter == FitParameter::mu1) mu1 = p.estimate;
    if (p.parameter == FitParameter::mu2) mu2 = p.estimate;
  }
  return !(mu1 >= kLeastMu1 && mu1 <= kLargestMu1) || mu2 > mu1;
}

std::vector<SlipFound> find_slips(const Problem& problem, const FitResult& result, const Typed& typed) {
  std::vector<SlipFound> found;
  const bool failing = is_failing(result), sound = !failing && !is_absurd(result);
  const auto take = [&](SlipFound slip) {
    if (plausible(problem, slip.values)) found.push_back(std::move(slip));
  };
  Typed looked_at = typed;
  if (typed.lengths && all_scale(problem)) {
    looked_at.lengths = false;
    if (!failing && !sound)
      for (const double factor : {0.1, 10.0}) take(scaled(result, factor));
  }
  Problem driven = problem;
  driven.trajectory_runs.clear();
  driven.start.clear();
  std::vector<Candidate> candidates;
  if (!driven.summary_runs.empty()) {
    candidates = magnitudes(looked_at);
    if (sound) candidates.erase(candidates.begin() + (typed.amplitude ? 1 : 0), candidates.end());
    if (failing) std::ranges::move(turns(typed, driven), std::back_inserter(candidates));
  }
  for (const Candidate& candidate : candidates) {
    Problem undone = driven;
    candidate.undo(undone);
    if (!within_bounds(undone)) continue;
    const auto slip = refit(undone, candidate);
    if (slip && slip->p_value > kExplained && !(sound && slip->chi2 > result.chi2)) take(*slip);
  }
  // Those as good as the best; of them the likeliest friction first.
  double best = HUGE_VAL;
  for (const SlipFound& slip : found) best = std::min(best, slip.chi2);
  std::erase_if(found, [&](const SlipFound& slip) { return slip.chi2 > best + kNearMinimum; });
  std::ranges::stable_sort(found, {}, [&](const SlipFound& slip) {
    return std::abs(std::log(known(problem, slip.values, FitParameter::mu1) / kUsualMu1));
  });
  return found;
}

}  // namespace tribotrack::fit
