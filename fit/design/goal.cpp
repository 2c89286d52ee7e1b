#include "fit/goal.h"

#include <algorithm>
#include <cmath>
#include <limits>

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
