#include <cmath>
#include <set>

#include "fit/residuals/sticking.h"
#include "fit/tools/parameter_text.h"
#include "fit/uncertainty/identifiability.h"

namespace tribotrack::fit::internal {
namespace {

constexpr double kBent = 2;  ///< how much farther a profile may reach than the covariance
constexpr const char* kRotationLaw =
    "All runs share one dtau and one drive: a sweep of phi alone only turns the picture (rotation law) and "
    "averages noise; add runs at other dtau.";

constexpr double kTradeOff = 0.95;
constexpr double kWeak = 0.3;
constexpr double kPulsesSeen = 3;

/// The flat or weak direction as "mu1 up 1 % is hidden by phase_lag_rad down 0.021 and ...".
std::string direction_in_words(const Unknowns& unknowns, const Eigen::VectorXd& values,
                               const Uncertainty& uncertainty, Eigen::Index k) {
  Eigen::VectorXd change = uncertainty.units.cwiseProduct(uncertainty.directions.col(k));
  Eigen::Index lead = 0;
  uncertainty.directions.col(k).cwiseAbs().maxCoeff(&lead);
  change *= 0.01 * uncertainty.units(lead) / change(lead);
  std::string text = change_in_words(unknowns.parameter(lead), change(lead), values(lead)) + " is hidden by ";
  bool first = true;
  for (Eigen::Index i = 0; i < change.size(); ++i) {
    const double share = std::abs(uncertainty.directions(i, k) / uncertainty.directions(lead, k));
    if (i == lead || share < 0.02) continue;
    text += (first ? "" : " and ") + change_in_words(unknowns.parameter(i), change(i), values(i));
    first = false;
  }
  return first ? std::string(to_string(unknowns.parameter(lead))) + " can take any value" : text;
}

std::string why_dead(const Problem& problem, FitParameter parameter) {
  bool pulses = false, driven = false;
  for (const auto& run : problem.summary_runs) {
    pulses = pulses || run.scenario.friction.pulse_width > 0;
    driven = true;
  }
  for (const auto& run : problem.trajectory_runs) {
    pulses = pulses || (!run.free_slide && run.scenario.friction.pulse_width > 0);
    driven = driven || !run.free_slide;
  }
  if (!driven && parameter != FitParameter::mu1 && parameter != FitParameter::scale)
    return "a free slide knows mu1 only; leave it out, or add runs on the moving platform";
  if (!pulses) return "no run has a pulse (dtau = 0); leave it out, or add runs with pulses";
  return "nothing seen depends on it at these values (does the part stick throughout?); fix it, or add runs "
         "where it matters";
}

/// The rotation law makes a sweep of phi alone repeat one measurement.
bool only_phi_varies(const Problem& problem) {
  if (!problem.trajectory_runs.empty() || problem.summary_runs.size() < 2) return false;
  const auto& first = problem.summary_runs.front().scenario;
  for (const auto& run : problem.summary_runs) {
    const auto& s = run.scenario;
    if (std::abs(s.friction.pulse_width - first.friction.pulse_width) > 1e-6 ||
        std::abs(s.drive.amplitude - first.drive.amplitude) > 1e-3 * first.drive.amplitude ||
        std::abs(s.drive.angular_frequency - first.drive.angular_frequency) >
            1e-3 * first.drive.angular_frequency)
      return false;
  }
  return true;
}

void worsen(Identifiability& result, Verdict verdict) {
  if (static_cast<int>(verdict) > static_cast<int>(result.verdict)) result.verdict = verdict;
}

}  // namespace

double range(const Unknowns& unknowns, FitParameter parameter, const Eigen::VectorXd& values) {
  const double mu1 = unknowns.value_of(FitParameter::mu1, values);
  switch (parameter) {
    case FitParameter::mu1:
    case FitParameter::mu2:
    case FitParameter::tilt_x:
    case FitParameter::tilt_y:
      return mu1;
    case FitParameter::lag:
      return 1;
    case FitParameter::delay:
      return 1 / unknowns.reference_frequency();
    default:
      return unknowns.value_of(parameter, values);
  }
}

std::vector<bool> moved_by_flat_direction(const Uncertainty& uncertainty) {
  std::vector<bool> moved(static_cast<std::size_t>(uncertainty.units.size()), false);
  for (Eigen::Index k = uncertainty.rank; k < uncertainty.units.size(); ++k)
    for (Eigen::Index i = 0; i < uncertainty.units.size(); ++i)
      if (std::abs(uncertainty.directions(i, k)) > 1e-4) moved[static_cast<std::size_t>(i)] = true;
  return moved;
}

Identifiability identifiability(const Unknowns& unknowns, const Eigen::VectorXd& values,
                                const Uncertainty& uncertainty) {
  Identifiability result;
  const Problem& problem = unknowns.problem();
  const Eigen::Index n = unknowns.reported();
  result.singular_values.assign(uncertainty.singular_values.begin(), uncertainty.singular_values.end());
  const double strongest = uncertainty.column_norms.maxCoeff();
  if (const auto stuck = stuck_throughout(problem)) {
    result.weak_directions.push_back(*stuck);
    worsen(result, Verdict::not_identifiable);
    return result;
  }
  if (const auto [numbers, wanted] = problem.data_and_unknowns(); numbers < wanted) {
    result.weak_directions.push_back(std::to_string(numbers) + " numbers for " + std::to_string(wanted) +
                                     " unknowns: add runs, fix a parameter, or give it a prior.");
    worsen(result, Verdict::not_identifiable);
  }

  std::set<Eigen::Index> dead;
  for (Eigen::Index i = 0; i < n; ++i)
    if (uncertainty.column_norms(i) <= 1e-9 * strongest || !(uncertainty.column_norms(i) > 0)) {
      dead.insert(i);
      result.weak_directions.push_back(std::string(to_string(unknowns.parameter(i))) +
                                       " moves no observable: " + why_dead(problem, unknowns.parameter(i)) +
                                       ".");
      worsen(result, Verdict::not_identifiable);
    }
  for (Eigen::Index k = uncertainty.rank; k < n; ++k) {
    Eigen::Index lead = 0;
    uncertainty.directions.col(k).cwiseAbs().maxCoeff(&lead);
    if (dead.count(lead)) continue;
    result.weak_directions.push_back(direction_in_words(unknowns, values, uncertainty, k) +
                                     ", exactly: fix one of them, or give it a prior.");
    worsen(result, Verdict::not_identifiable);
  }

  const auto flat = moved_by_flat_direction(uncertainty);
  const Eigen::VectorXd sd = uncertainty.covariance.diagonal().cwiseMax(0).cwiseSqrt();
  for (Eigen::Index i = 0; i < n; ++i) {
    if (flat[static_cast<std::size_t>(i)]) continue;
    const FitParameter parameter = unknowns.parameter(i);
    const double widest = range(unknowns, parameter, values);
    const std::string shown = to_string(parameter) + std::string(" = ") +
                              number(values(i) * display_factor(parameter), 4) + " +- " +
                              number(sd(i) * display_factor(parameter), 2);
    if (sd(i) > widest) {
      result.weak_directions.push_back(shown + " is not pinned: its sd exceeds the range it can have (" +
                                       number(widest * display_factor(parameter), 2) + ").");
      worsen(result, Verdict::not_identifiable);
    } else if (parameter == FitParameter::mu2 && sd(i) > 0.5 * values(i)) {
      result.weak_directions.push_back(shown + ": the data give an upper limit only.");
      worsen(result, Verdict::weak);
    } else if (sd(i) > kWeak * widest && parameter != FitParameter::mu2) {
      result.weak_directions.push_back(shown + " is only loosely pinned.");
      worsen(result, Verdict::weak);
    }
    if (const auto prior = problem.prior.find(parameter);
        prior != problem.prior.end() && sd(i) > 0.9 * prior->second.sd)
      result.weak_directions.push_back(std::string(to_string(parameter)) +
                                       " is told by its prior, not by the data.");
  }

  // Where mu1 = mu2 is not excluded, the pulses may do nothing, and no lag is better than another.
  const auto mu1 = unknowns.find(FitParameter::mu1), mu2 = unknowns.find(FitParameter::mu2);
  const bool pulses_placed = unknowns.find(FitParameter::lag) || unknowns.find(FitParameter::delay);
  if (mu1 && mu2 && pulses_placed) {
    const double difference = std::abs(values(*mu1) - values(*mu2));
    const double variance = uncertainty.covariance(*mu1, *mu1) + uncertainty.covariance(*mu2, *mu2) -
                            2 * uncertainty.covariance(*mu1, *mu2);
    if (difference < kPulsesSeen * std::sqrt(std::max(0.0, variance))) {
      result.weak_directions.push_back("mu1 and mu2 agree within " + number(kPulsesSeen) +
                                       " sd: the pulses may have no effect, and then the lag means nothing; "
                                       "check that the actuator works, or "
                                       "fit mu1 alone with mu2 fixed.");
      worsen(result, Verdict::not_identifiable);
    }
  }

  bool traded = false;
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = i + 1; j < n; ++j) {
      if (flat[static_cast<std::size_t>(i)] || flat[static_cast<std::size_t>(j)]) continue;
      const double correlation = uncertainty.covariance(i, j) / (sd(i) * sd(j));
      if (!(std::abs(correlation) > kTradeOff)) continue;
      const double change = 0.01 * uncertainty.units(i);
      const double other = uncertainty.covariance(i, j) / (sd(i) * sd(i)) * change;
      result.weak_directions.push_back(change_in_words(unknowns.parameter(i), change, values(i)) +
                                       " is hidden by " +
                                       change_in_words(unknowns.parameter(j), other, values(j)) +
                                       " (correlation " + number(correlation, 3) + ").");
      worsen(result, Verdict::weak);
      traded = true;
    }
  if ((traded || result.verdict != Verdict::identifiable) && only_phi_varies(problem))
    result.weak_directions.push_back(kRotationLaw);
  return result;
}

void compare_with_profiles(const Unknowns& unknowns, const std::vector<ParameterEstimate>& parameters,
                           Identifiability& result) {
  const bool was_identifiable = result.verdict == Verdict::identifiable;
  const auto reach = [](const Interval& interval, double estimate) {
    return std::max(interval.high - estimate, estimate - interval.low);
  };
  for (const ParameterEstimate& p : parameters) {
    const double by_profile = reach(p.profile_ci95, p.estimate), by_covariance = reach(p.ci95, p.estimate);
    if (!(by_profile > kBent * by_covariance)) continue;  // NaN: no profile
    result.weak_directions.push_back(std::string(to_string(p.parameter)) +
                                     ": the likelihood is far from a parabola, its profile reaches " +
                                     (std::isfinite(by_profile)
                                          ? number(by_profile / by_covariance, 2) + " times as far as"
                                          : "beyond what") +
                                     " the covariance says: quote the profile.");
    worsen(result, Verdict::weak);
  }
  if (was_identifiable && result.verdict != Verdict::identifiable && only_phi_varies(unknowns.problem()))
    result.weak_directions.push_back(kRotationLaw);
}

}  // namespace tribotrack::fit::internal
