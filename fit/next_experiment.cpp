#include "fit/internal/next_experiment.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "fit/internal/display.h"
#include "fit/internal/forecast.h"
#include "fit/internal/identifiability.h"
#include "fit/internal/parallel.h"

namespace tribotrack::fit::internal {
namespace {

constexpr int kPhases = 8, kWidths = 7;  ///< grid: phi by pi/4, dtau by pi/4
constexpr std::pair<double, double> kDrives[] = {{1, 1}, {0.8, 1}, {1.25, 1}, {1, 0.8}, {1, 1.25}};
constexpr std::size_t kForecastAgain = 3;
constexpr double kRough = 1e-3, kGood = 1e-4;  ///< tolerances of the forecasts

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

/// What is to become small: the log-determinant, or the log-variance of one parameter.
double size(const Eigen::MatrixXd& covariance, std::optional<Eigen::Index> aim) {
  return aim ? std::log(covariance(*aim, *aim)) : log_determinant(covariance);
}

class Search {
 public:
  Search(const Residuals& residuals, const Eigen::VectorXd& values, const Eigen::MatrixXd& jacobian, double t)
      : unknowns_(residuals.unknowns()),
        values_(values),
        units_(unknowns_.natural_units(values)),
        t_(t),
        forecaster_(residuals, values) {
    information_ = units_.asDiagonal() * (jacobian.transpose() * jacobian) * units_.asDiagonal();
    for (Eigen::Index i = 0; i < unknowns_.common(); ++i) {
      const double widest = range(unknowns_, unknowns_.parameter(i), values) / units_(i);
      information_(i, i) += 1 / (widest * widest);
    }
    now_ = reported_covariance(information_, unknowns_.reported());
  }

  /// Forecasts over the whole grid.
  void sample(int threads) {
    const Candidate own = forecaster_.drive_so_far();
    std::vector<Candidate> seeds;
    for (const auto& [a, w] : kDrives)
      for (int j = 1; j <= kWidths; ++j)
        seeds.push_back({0, j * std::numbers::pi / 4, a * own.amplitude, w * own.angular_frequency});
    std::vector<std::optional<Forecast>> forecasts(seeds.size());
    parallel_for(seeds.size(), threads,
                 [&](std::size_t k) { forecasts[k] = forecaster_.forecast(seeds[k], kRough); });
    for (const auto& forecast : forecasts)
      for (int i = 0; forecast && i < kPhases; ++i)
        sampled_.push_back(forecaster_.turned(*forecast, i * std::numbers::pi / 4));
  }

  std::optional<NextExperiment> best(std::optional<Eigen::Index> aim, bool own_drive) const {
    const Candidate own = forecaster_.drive_so_far();
    std::vector<std::pair<double, const Forecast*>> order;
    for (const Forecast& forecast : sampled_) {
      const Candidate& c = forecast.candidate;
      const bool same = c.amplitude == own.amplitude && c.angular_frequency == own.angular_frequency;
      if (same == own_drive) order.emplace_back(size(after(forecast), aim), &forecast);
    }
    std::stable_sort(order.begin(), order.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    std::optional<Forecast> chosen;
    double smallest = size(now_, aim);
    for (std::size_t k = 0; k < std::min(order.size(), kForecastAgain); ++k) {
      const auto forecast = forecaster_.forecast(order[k].second->candidate, kGood);
      if (!forecast || !(size(after(*forecast), aim) < smallest)) continue;
      smallest = size(after(*forecast), aim);
      chosen = forecast;
    }
    if (!chosen) return std::nullopt;
    return tell(*chosen, aim, own_drive);
  }

  /// How much smaller the logarithm of the aim becomes.
  double gain(const NextExperiment& next) const {
    const auto forecast =
        forecaster_.forecast({next.phi, next.dtau, next.amplitude, next.angular_frequency}, kGood);
    return forecast ? log_determinant(now_) - log_determinant(after(*forecast)) : 0;
  }

 private:
  Eigen::MatrixXd after(const Forecast& forecast) const {
    return reported_covariance(information_ + forecast.rows.transpose() * forecast.rows,
                               unknowns_.reported());
  }

  NextExperiment tell(const Forecast& forecast, std::optional<Eigen::Index> aim, bool own_drive) const {
    const Eigen::MatrixXd covariance = after(forecast);
    NextExperiment next;
    next.phi = forecast.candidate.phi;
    next.dtau = forecast.candidate.dtau;
    next.amplitude = forecast.candidate.amplitude;
    next.angular_frequency = forecast.candidate.angular_frequency;
    if (aim) next.aim = unknowns_.parameter(*aim);
    next.sentence = aim         ? std::string("For ") + to_string(*next.aim) + " alone film"
                    : own_drive ? std::string("Film next")
                                : std::string("More would tell, if the platform can be driven so,");
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
      next.predicted_ci95[parameter] = {values_(i) - t_ * sd, values_(i) + t_ * sd};
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
  Eigen::MatrixXd information_, now_;
  std::vector<Forecast> sampled_;
};

}  // namespace

NextExperiments next_experiments(const Residuals& residuals, const Eigen::VectorXd& values,
                                 const Eigen::MatrixXd& jacobian, double t, int threads) {
  NextExperiments result;
  const Unknowns& unknowns = residuals.unknowns();
  if (unknowns.problem().summary_runs.empty() || !(unknowns.reference_amplitude() > 0)) return result;
  Search search(residuals, values, jacobian, t);
  search.sample(threads);
  result.best = search.best(std::nullopt, true);
  for (Eigen::Index i = 0; i < unknowns.reported(); ++i) {
    const auto aimed = search.best(i, true);
    if (aimed && result.best && (aimed->phi != result.best->phi || aimed->dtau != result.best->dtau))
      result.others.push_back(*aimed);
  }
  const auto driven = search.best(std::nullopt, false);
  const double worth_it = 0.2 * static_cast<double>(unknowns.reported());
  if (driven && search.gain(*driven) > (result.best ? search.gain(*result.best) : 0) + worth_it)
    result.others.push_back(*driven);
  return result;
}

}  // namespace tribotrack::fit::internal
