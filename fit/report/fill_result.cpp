#include "fit/report/fill_result.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "fit/minimum/multi_start.h"
#include "fit/residuals/sticking.h"
#include "fit/tools/parameter_text.h"
#include "fit/tools/thresholds.h"
#include "fit/uncertainty/identifiability.h"
#include "fit/uncertainty/influence.h"
#include "fit/uncertainty/intervals.h"

namespace tribotrack::fit::internal {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kTold = 0.1;  ///< of half an interval's width: a difference not worth telling

}  // namespace

void fill_parameters(const Unknowns& unknowns, const Eigen::VectorXd& values, const Uncertainty& uncertainty,
                     const std::vector<double>& t, FitResult& result) {
  const Eigen::Index n = unknowns.reported();
  auto flat = moved_by_flat_direction(uncertainty);
  if (stuck_throughout(unknowns.problem())) flat.assign(flat.size(), true);  // noise mistaken for motion
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

void fill_influence(const Residuals& residuals, const Minimum& best, const Uncertainty& uncertainty,
                    FitResult& result) {
  const Eigen::MatrixXd influence = influence_of_runs(residuals, best, uncertainty);
  for (std::size_t run = 0; run < result.runs.size(); ++run) {
    const Eigen::VectorXd row = influence.row(static_cast<Eigen::Index>(run));
    result.runs[run].influence.assign(row.begin(), row.end());
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

void fill_minima(const Residuals& residuals, const std::vector<KnownMinimum>& minima, FitResult& result) {
  const Unknowns& unknowns = residuals.unknowns();
  const double excess = residuals.excess(minima.front().minimum.chi2);
  result.minima.emplace_back();
  for (const ParameterEstimate& p : result.parameters) result.minima.front().values[p.parameter] = p.estimate;
  for (std::size_t i = 1; i < minima.size(); ++i) {
    const Minimum& other = minima[i].minimum;
    const double above = (other.chi2 - minima.front().minimum.chi2) / excess;
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
    minimum.sentence =
        fmt::format("Another minimum fits nearly as well (chi2 higher by {}): {}.", number(above, 2), list);
    result.warnings.push_back(minimum.sentence);
    result.minima.push_back(minimum);
  }
}

void fill_failures(const Residuals& residuals, const Minimum& best, FitResult& result) {
  result.failed_evaluations = residuals.failures().count();
  const Eigen::VectorXd values = residuals.unknowns().values(best.z);
  const double near = kNearMinimum * residuals.excess(best.chi2);
  std::size_t count = 0;
  double nearest = kInfinity;
  std::string reason;
  for (const auto& failure : residuals.failures().kept()) {
    const double distance = (best.jacobian * (failure.values - values)).squaredNorm();
    if (!(distance < near)) continue;
    ++count;
    if (distance < nearest) nearest = distance, reason = failure.reason;
  }
  if (count > 0)
    result.warnings.push_back(fmt::format(
        "The model could not be evaluated at {} of the values tried within three standard deviations "
        "of the minimum ({}): intervals may end there too early.",
        count, reason));
}

}  // namespace tribotrack::fit::internal
