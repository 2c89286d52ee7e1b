#include "fit/uncertainty/identifiability.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "fit/rounding.h"
#include "fit/tools/parameter_text.h"
#include "fit/tools/parameters.h"

namespace tribotrack::fit::internal {
namespace {

constexpr double kNoSensitivity = 1e-9;  ///< sensitivity relative to the strongest parameter's: none
constexpr double kTradeOff = 0.95;       ///< correlation
constexpr double kHopeless = 10;         ///< sd over the range: whatever its profile says
constexpr double kLoose = 0.3;           ///< sd relative to the parameter's range
constexpr double kUpperLimit = 0.5;      ///< sd of mu2 relative to itself
constexpr double kPulsesSeen = 3;        ///< sd between mu1 and mu2
constexpr double kByPrior = 0.9;         ///< sd relative to the prior's
constexpr double kBent = 2;              ///< how much farther a profile may reach than the covariance
constexpr const char* kRotationLaw =
    "All runs share one dtau and one drive: a sweep of phi alone only turns the picture (rotation law) and "
    "averages noise; add runs at other dtau.";

/// The flat or weak direction as "mu1 up 1 % is hidden by phase_lag_rad down 0.021 and ...".
std::string direction_text(const Unknowns& unknowns, const Eigen::VectorXd& values,
                           const Uncertainty& uncertainty, Eigen::Index k) {
  Eigen::VectorXd change = uncertainty.units.cwiseProduct(uncertainty.directions.col(k));
  Eigen::Index lead = 0;
  uncertainty.directions.col(k).cwiseAbs().maxCoeff(&lead);
  change *= 0.01 * uncertainty.units(lead) / change(lead);
  std::string text = change_text(unknowns.parameter(lead), change(lead), values(lead)) + " is hidden by ";
  bool first = true;
  for (Eigen::Index i = 0; i < change.size(); ++i) {
    const double share = std::abs(uncertainty.directions(i, k) / uncertainty.directions(lead, k));
    if (i == lead || share < 0.02) continue;
    text += (first ? "" : " and ") + change_text(unknowns.parameter(i), change(i), values(i));
    first = false;
  }
  return first ? std::string(to_string(unknowns.parameter(lead))) + " can take any value" : text;
}

std::string why_dead(const Problem& problem, FitParameter parameter) {
  const bool driven = !problem.summary_runs.empty() || problem.has_driven_tracks();
  if (!driven && parameter != FitParameter::mu1 && parameter != FitParameter::scale)
    return "a free slide depends on mu1 only; leave it out, or add runs on the moving platform";
  if (!problem.has_pulses()) return "no run has a pulse (dtau = 0); leave it out, or add runs with pulses";
  return "no measurement depends on it at these values (does the part stick throughout?); fix it, or add "
         "runs "
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

/// The checks one after the other, each adding its findings.
class Judge {
 public:
  Judge(const Unknowns& unknowns, const Eigen::VectorXd& values, const Uncertainty& uncertainty,
        const std::vector<ParameterEstimate>& parameters)
      : unknowns_(unknowns),
        parameters_(parameters),
        profiled_(!parameters.empty() && !std::isnan(parameters.front().profile_ci95.low)),
        problem_(unknowns.problem()),
        values_(values),
        uncertainty_(uncertainty),
        flat_(moved_by_flat_direction(uncertainty)),
        sd_(uncertainty.covariance.diagonal().cwiseMax(0).cwiseSqrt()) {
    result.singular_values.assign(uncertainty.singular_values.begin(), uncertainty.singular_values.end());
  }

  /// True where nothing moved: then nothing else is worth checking.
  bool stuck() {
    const auto bound = problem_.stuck_throughout();
    if (bound) add(Verdict::not_identifiable, *bound);
    return bound.has_value();
  }

  /// A track has always enough.
  void count_data() {
    const auto known =
        std::ranges::count_if(problem_.prior, [&](const auto& p) { return problem_.fits(p.first); });
    const std::size_t numbers = 2 * problem_.summary_runs.size() + static_cast<std::size_t>(known);
    if (problem_.trajectory_runs.empty() && numbers < problem_.free.size())
      add(Verdict::not_identifiable,
          fmt::format("{} numbers for {} unknowns: add runs, fix a parameter, or give it a prior.", numbers,
                      problem_.free.size()));
  }

  void find_dead_parameters() {
    for (Eigen::Index i = 0; i < unknowns_.reported(); ++i)
      if (dead(i))
        add(Verdict::not_identifiable,
            fmt::format("{} moves no observable: {}.", name(i), why_dead(problem_, unknowns_.parameter(i))));
  }

  void find_flat_directions() {
    for (Eigen::Index k = uncertainty_.rank; k < unknowns_.reported(); ++k) {
      Eigen::Index lead = 0;
      uncertainty_.directions.col(k).cwiseAbs().maxCoeff(&lead);
      if (!dead(lead))
        add(Verdict::not_identifiable, direction_text(unknowns_, values_, uncertainty_, k) +
                                           ", exactly: fix one of them, or give it a prior.");
    }
  }

  void find_loose_parameters() {
    for (Eigen::Index i = 0; i < unknowns_.reported(); ++i)
      if (!flat_[static_cast<std::size_t>(i)]) check_precision(i);
  }

  /// Pulses lower friction. Where mu1 = mu2 is not excluded they may have no effect, and no lag is better
  /// than another.
  void check_pulses() {
    const auto mu1 = unknowns_.find(FitParameter::mu1), mu2 = unknowns_.find(FitParameter::mu2);
    const bool pulses_placed = unknowns_.find(FitParameter::lag) || unknowns_.find(FitParameter::delay);
    if (!mu1 || !mu2) return;
    const auto& covariance = uncertainty_.covariance;
    const double raised = values_(*mu2) - values_(*mu1);
    const double variance = covariance(*mu1, *mu1) + covariance(*mu2, *mu2) - 2 * covariance(*mu1, *mu2);
    const double seen = kPulsesSeen * std::sqrt(std::max(0.0, variance));
    if (raised > seen)
      add(Verdict::not_identifiable,
          fmt::format("mu2 lies above mu1 by more than {} sd: pulses would raise friction, which the model "
                      "does not know; check phi and dtau of the runs, and which state of the actuator the "
                      "pulse is.",
                      number(kPulsesSeen)));
    else if (pulses_placed && (!profiled_ || raised > 0) && raised > -seen)
      add(Verdict::not_identifiable,
          fmt::format("mu1 and mu2 agree within {} sd: the pulses may have no effect, and then the lag means "
                      "nothing; check that the actuator works, or fit mu1 alone with mu2 fixed.",
                      number(kPulsesSeen)));
  }

  void find_trade_offs() {
    bool traded = false;
    for (Eigen::Index i = 0; i < unknowns_.reported(); ++i)
      for (Eigen::Index j = i + 1; j < unknowns_.reported(); ++j) {
        if (flat_[static_cast<std::size_t>(i)] || flat_[static_cast<std::size_t>(j)]) continue;
        const double covariance = uncertainty_.covariance(i, j), correlation = covariance / (sd_(i) * sd_(j));
        if (!(std::abs(correlation) > kTradeOff)) continue;
        const double change = 0.01 * uncertainty_.units(i);
        const double other = covariance / (sd_(i) * sd_(i)) * change;
        result.weak_directions.push_back(fmt::format(
            "{} is hidden by {} (correlation {}).", change_text(unknowns_.parameter(i), change, values_(i)),
            change_text(unknowns_.parameter(j), other, values_(j)), number(correlation, 3)));
        traded = true;
      }
    if ((traded || result.verdict != Verdict::identifiable) && only_phi_varies(problem_))
      result.weak_directions.push_back(kRotationLaw);
  }

  void check_profiles() {
    if (!profiled_) return;
    const auto reach = [](const Interval& interval, double estimate) {
      return std::max(interval.high - estimate, estimate - interval.low);
    };
    for (std::size_t i = 0; i < parameters_.size(); ++i) {
      const ParameterEstimate& p = parameters_[i];
      if (flat_[i] || dead(static_cast<Eigen::Index>(i))) continue;
      const double by_profile = reach(p.profile_ci95, p.estimate),
                   by_covariance = reach(p.covariance_ci95, p.estimate);
      const std::string name = to_string(p.parameter);
      if (!std::isfinite(by_profile))
        add(Verdict::not_identifiable,
            name + " is not determined: other parameters make up for any value of it on at least one side.");
      else if (p.ci95_pieces.size() > 1)
        add(Verdict::weak, name + ": more than one minimum fits, and the interval is in pieces.");
      else if (by_profile > kBent * by_covariance)
        add(Verdict::weak,
            fmt::format("{}: the likelihood is far from a parabola, the interval quoted (profile) reaches {} "
                        "times as far as the covariance.",
                        name, number(by_profile / by_covariance, 2)));
    }
  }

  Identifiability result;

 private:
  void add(Verdict verdict, const std::string& sentence) {
    result.weak_directions.push_back(sentence);
    result.verdict = std::max(result.verdict, verdict);
  }
  std::string name(Eigen::Index i) const { return to_string(unknowns_.parameter(i)); }
  bool dead(Eigen::Index i) const {
    const double norm = uncertainty_.column_norms(i);
    return norm <= kNoSensitivity * uncertainty_.column_norms.maxCoeff() || !(norm > 0);
  }

  void check_precision(Eigen::Index i) {
    const FitParameter parameter = unknowns_.parameter(i);
    const double factor = display_factor(parameter);
    const double widest = parameter == FitParameter::mu2 ? unknowns_.value_of(FitParameter::mu1, values_)
                                                         : uncertainty_.units(i);
    const std::string shown = fmt::format("{} = {}", name(i), quoted(values_(i) * factor, sd_(i) * factor));
    // A profile ends where conditions cannot follow, which is no knowledge of the parameter.
    if (sd_(i) > (profiled_ ? kHopeless : 1) * widest)
      add(Verdict::not_identifiable,
          fmt::format("{} is not determined: its sd exceeds the range it can have ({}).", shown,
                      number(widest * factor, 2)));
    else if (parameter == FitParameter::mu2 && sd_(i) > kUpperLimit * values_(i))
      add(Verdict::weak, shown + ": the data give an upper limit only.");
    else if (sd_(i) > kLoose * widest && parameter != FitParameter::mu2)
      add(Verdict::weak, shown + " is only loosely determined.");
    if (const auto prior = problem_.prior.find(parameter);
        prior != problem_.prior.end() && sd_(i) > kByPrior * prior->second.sd)
      result.weak_directions.push_back(name(i) + " is determined by its prior, not by the data.");
  }

  const Unknowns& unknowns_;
  const std::vector<ParameterEstimate>& parameters_;
  bool profiled_;
  const Problem& problem_;
  const Eigen::VectorXd& values_;
  const Uncertainty& uncertainty_;
  std::vector<bool> flat_;
  Eigen::VectorXd sd_;
};

}  // namespace

std::vector<bool> moved_by_flat_direction(const Uncertainty& uncertainty) {
  std::vector<bool> moved(static_cast<std::size_t>(uncertainty.units.size()), false);
  for (Eigen::Index k = uncertainty.rank; k < uncertainty.units.size(); ++k)
    for (Eigen::Index i = 0; i < uncertainty.units.size(); ++i)
      if (std::abs(uncertainty.directions(i, k)) > 1e-4) moved[static_cast<std::size_t>(i)] = true;
  return moved;
}

Identifiability identifiability(const Unknowns& unknowns, const Eigen::VectorXd& values,
                                const Uncertainty& uncertainty,
                                const std::vector<ParameterEstimate>& parameters) {
  Judge judge(unknowns, values, uncertainty, parameters);
  if (judge.stuck()) return judge.result;
  judge.count_data();
  judge.find_dead_parameters();
  judge.find_flat_directions();
  judge.find_loose_parameters();
  judge.check_profiles();
  judge.check_pulses();
  judge.find_trade_offs();
  return judge.result;
}

}  // namespace tribotrack::fit::internal
