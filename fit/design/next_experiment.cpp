#include "fit/design/next_experiment.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "fit/design/forecast.h"
#include "fit/goal.h"
#include "fit/tools/dense.h"
#include "fit/tools/parameter_text.h"
#include "fit/tools/stage_progress.h"
#include "fit/uncertainty/identifiability.h"
#include "model/parallel.h"

namespace tribotrack::fit::internal {
namespace {

constexpr int kPhases = 8;
constexpr std::size_t kWidths = 7;
constexpr double kGridStep = std::numbers::pi / 4;  ///< of the grid in phi and dtau
constexpr double kWorthMentioning = 0.02;           ///< shorter standard deviation than with the best for all
constexpr double kWorthAnotherDrive = 0.1;          ///< shorter standard deviations than with the own drive
constexpr std::pair<double, double> kDrives[] = {{1, 1}, {0.8, 1}, {1.25, 1}, {1, 0.8}, {1, 1.25}};
constexpr double kForecastTolerance = 1e-3;  ///< of the forecasts: derivatives to better than 1e-3

constexpr long kMostSteps = 500'000;  ///< of all integrations: about a second

/// Covariance of the reported parameters from the information on all.
Eigen::MatrixXd reported_covariance(const Eigen::MatrixXd& information, Eigen::Index reported) {
  return inverse_symmetric(information).topLeftCorner(reported, reported);
}

double log_determinant(const Eigen::MatrixXd& covariance) {
  const Factor factor(covariance);
  return factor.positive() ? 2 * factor.log_determinant_of_root() : std::numeric_limits<double>::infinity();
}

/// What is to become small: the log-determinant, or the log-variance of one parameter.
double size(const Eigen::MatrixXd& covariance, std::optional<Eigen::Index> aim) {
  return aim ? std::log(covariance(*aim, *aim)) : log_determinant(covariance);
}

class Search {
 public:
  Search(const Residuals& residuals, const Eigen::VectorXd& values, const Linearised& at, double t,
         const FitOptions& options)
      : unknowns_(residuals.unknowns()),
        values_(values),
        units_(unknowns_.natural_units(values)),
        t_(t),
        forecaster_(residuals, values),
        threads_(options.threads),
        stage_(options, "next experiment") {
    information_ = at.scaled(units_).eliminated().normal();
    for (Eigen::Index i = 0; i < unknowns_.reported(); ++i) {  // conditions have their priors
      const bool is_mu2 = unknowns_.parameter(i) == FitParameter::mu2;
      const double widest = is_mu2 ? unknowns_.value_of(FitParameter::mu1, values) / units_(i) : 1;
      information_(i, i) += 1 / (widest * widest);
    }
    now_ = reported_covariance(information_, unknowns_.reported());
  }

  /// Forecasts over the whole grid.
  void sample() {
    const Candidate own = forecaster_.drive_so_far();
    for (const auto& [a, w] : kDrives)
      for (int i = 0; i < kPhases && !late(); ++i) {
        std::vector<Candidate> candidates;
        for (std::size_t j = 1; j <= kWidths; ++j)
          candidates.push_back({i * kGridStep, static_cast<double>(j) * kGridStep, a * own.amplitude,
                                w * own.angular_frequency});
        add_forecasts(candidates, a == 1 && w == 1);
      }
  }
  /// The integrations so far took too many steps: counted, since by a clock no two results would be alike.
  bool late() const { return steps_ > kMostSteps; }

  std::optional<NextExperiment> best(std::optional<Eigen::Index> aim, bool own_drive) const {
    const Forecast* chosen = nullptr;
    double smallest = size(now_, aim);
    for (const Forecast& forecast : own_drive ? with_own_drive_ : with_another_) {
      const double here = size(after(forecast), aim);
      if (!(here < smallest)) continue;
      smallest = here;
      chosen = &forecast;
    }
    if (!chosen) return std::nullopt;
    return describe(*chosen, aim, own_drive);
  }

  /// How much the standard deviation aimed at (their geometric mean without an aim) shrinks, as a logarithm.
  double gain(const std::optional<NextExperiment>& next, std::optional<Eigen::Index> aim) const {
    if (!next) return 0;
    double sum = 0;
    for (Eigen::Index i = 0; i < unknowns_.reported(); ++i)
      if (!aim || i == *aim)
        sum += std::log(std::sqrt(now_(i, i)) * units_(i) / next->predicted_sd.at(unknowns_.parameter(i)));
    return aim ? sum : sum / static_cast<double>(unknowns_.reported());
  }

 private:
  void add_forecasts(const std::vector<Candidate>& candidates, bool own_drive) {
    std::vector<Forecast> all(candidates.size());
    stage_.expect(all.size());
    parallel_for(all.size(), threads_, [&](std::size_t k) {
      all[k] = forecaster_.forecast(candidates[k], kForecastTolerance);
      stage_.done();
    });
    for (Forecast& one : all) {
      steps_ += one.steps;
      if (!one.empty()) (own_drive ? with_own_drive_ : with_another_).push_back(std::move(one));
    }
  }

  Eigen::MatrixXd after(const Forecast& forecast) const {
    return reported_covariance(information_ + forecast.information, unknowns_.reported());
  }

  NextExperiment describe(const Forecast& forecast, std::optional<Eigen::Index> aim, bool own_drive) const {
    const Eigen::MatrixXd covariance = after(forecast);
    NextExperiment next;
    next.phi = forecast.candidate.phi;
    next.dtau = forecast.candidate.dtau;
    next.amplitude = forecast.candidate.amplitude;
    next.angular_frequency = forecast.candidate.angular_frequency;
    if (aim) next.aim = unknowns_.parameter(*aim);
    next.sentence = aim ? std::string("For ") + to_string(*next.aim) + " alone film"
                        : std::string(own_drive ? "Film next" : "More informative");
    if (!own_drive) next.sentence += ", if the platform can be driven so,";
    next.sentence += " phi = " + number(next.phi / std::numbers::pi) +
                     " pi, dtau = " + number(next.dtau / std::numbers::pi) + " pi";
    if (!own_drive)
      next.sentence +=
          ", A = " + number(1e3 * next.amplitude) + " mm, w = " + number(next.angular_frequency) + " rad/s";
    next.sentence += ", measured as well as the runs so far:";
    for (Eigen::Index i = 0; i < unknowns_.reported(); ++i) {
      const FitParameter parameter = unknowns_.parameter(i);
      const double before = std::sqrt(now_(i, i)) * units_(i), sd = std::sqrt(covariance(i, i)) * units_(i);
      next.predicted_sd[parameter] = sd;
      next.predicted_ci95[parameter] = interval95(unknowns_.transform(i), parameter, values_(i), sd, t_);
      next.sentence += std::string(i > 0 ? ", " : " ") + "sd(" + to_string(parameter) + ") " +
                       number(before * display_factor(parameter), 2) + " -> " +
                       number(sd * display_factor(parameter), 2);
    }
    next.sentence += ".";
    return next;
  }

  const Unknowns& unknowns_;
  Eigen::VectorXd values_, units_;
  double t_;
  Forecaster forecaster_;
  int threads_;
  Stage stage_;
  long steps_ = 0;
  Eigen::MatrixXd information_, now_;
  std::vector<Forecast> with_own_drive_, with_another_;
};

}  // namespace

NextExperiments next_experiments(const Residuals& residuals, const Eigen::VectorXd& values,
                                 const Linearised& at, double t, const FitOptions& options) {
  NextExperiments result;
  const Unknowns& unknowns = residuals.unknowns();
  if (!(unknowns.reference_amplitude() > 0)) return result;
  Search search(residuals, values, at, t, options);
  search.sample();
  result.best = search.best(std::nullopt, true);
  const auto same = [](const NextExperiment& a, const std::optional<NextExperiment>& b) {
    return b && a.phi == b->phi && a.dtau == b->dtau && a.amplitude == b->amplitude &&
           a.angular_frequency == b->angular_frequency;
  };
  for (Eigen::Index i = 0; i < unknowns.reported(); ++i)
    if (const auto aimed = search.best(i, true);
        aimed && search.gain(aimed, i) > search.gain(result.best, i) + kWorthMentioning)
      result.others.push_back(*aimed);
  const auto driven = search.best(std::nullopt, false);
  if (driven &&
      search.gain(driven, std::nullopt) > search.gain(result.best, std::nullopt) + kWorthAnotherDrive)
    result.others.push_back(*driven);
  for (Eigen::Index i = 0; i < unknowns.reported(); ++i) {
    const auto own = search.best(i, true), aimed = search.best(i, false);
    if (aimed && !same(*aimed, driven) && search.gain(aimed, i) > search.gain(own, i) + kWorthAnotherDrive)
      result.others.push_back(*aimed);
  }
  if (search.late()) return {.best = {}, .others = {}, .given_up = true};
  return result;
}

}  // namespace tribotrack::fit::internal

namespace tribotrack::fit {
namespace {

double half_width(const Interval& interval) {
  return 0.5 * (interval.high - interval.low);
}

double allowed(const Goal& goal, const FitResult& result) {
  return goal.relative ? goal.half_width * std::abs(result.value(goal.parameter)) : goal.half_width;
}

/// The worst ratio after a run.
double predicted(const std::vector<Goal>& goals, const FitResult& result, const NextExperiment& next) {
  double worst = 0;
  for (const Goal& goal : goals)
    if (const auto interval = next.predicted_ci95.find(goal.parameter); interval != next.predicted_ci95.end())
      worst = std::max(worst, half_width(interval->second) / allowed(goal, result));
  return worst;
}

}  // namespace

double ratio_to(const Goal& goal, const FitResult& result) {
  const double value = result.value(goal.parameter);
  const auto found = std::ranges::find(result.parameters, goal.parameter, &ParameterEstimate::parameter);
  const double ratio = half_width(found->ci95) / allowed(goal, result);
  return std::isfinite(value) && std::isfinite(ratio) ? ratio : std::numeric_limits<double>::infinity();
}

bool all_reached(const std::vector<Goal>& goals, const FitResult& result) {
  return !goals.empty() && result.usable() &&
         std::ranges::all_of(goals, [&](const Goal& goal) { return ratio_to(goal, result) <= 1; });
}

const NextExperiment* next_for(const std::vector<Goal>& goals, const FitResult& result) {
  const auto& best = result.next_experiment;
  if (!best) return nullptr;
  const NextExperiment* chosen = &*best;
  for (const NextExperiment& other : result.other_next_experiments) {
    const bool same_drive =
        other.amplitude == best->amplitude && other.angular_frequency == best->angular_frequency;
    if (same_drive && predicted(goals, result, other) < predicted(goals, result, *chosen)) chosen = &other;
  }
  return chosen;
}

}  // namespace tribotrack::fit
