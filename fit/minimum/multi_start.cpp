#include "fit/minimum/multi_start.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "fit/minimum/screen.h"
#include "fit/tools/stage_progress.h"
#include "fit/tools/statistics.h"
#include "fit/tools/thresholds.h"
#include "model/alpha_v.h"
#include "model/parallel.h"

namespace tribotrack::fit::internal {
namespace {

constexpr std::size_t kTracks = 6;        ///< basins that a fit to tracks descends into at first
constexpr double kRoughDecrement = 0.01;  ///< a tenth of a standard deviation

}  // namespace

bool same(const Unknowns& unknowns, const Minimum& a, const Minimum& b, double spread) {
  Eigen::VectorXd other = b.z;
  if (const auto lag = unknowns.find(FitParameter::lag))
    other(*lag) = a.z(*lag) + model::wrap_angle(b.z(*lag) - a.z(*lag));
  return std::abs(b.chi2 - a.chi2) < 0.5 * spread && a.distance(unknowns, other) < 0.25 * spread;
}

bool admissible(const Unknowns& unknowns, const Eigen::VectorXd& z) {
  const Eigen::VectorXd values = unknowns.values(z);
  return !unknowns.find(FitParameter::mu2) ||
         unknowns.value_of(FitParameter::mu2, values) <= unknowns.value_of(FitParameter::mu1, values);
}

Eigen::VectorXd fold_lag(const Unknowns& unknowns, Eigen::VectorXd z) {
  if (const auto lag = unknowns.find(FitParameter::lag)) z(*lag) = model::wrap_angle(z(*lag));
  return z;
}

Search multi_start(const Residuals& residuals, const FitOptions& options) {
  const auto& unknowns = residuals.unknowns();
  Residuals rough = residuals;
  rough.set_tolerance(residuals.tolerance_for(0.3, 1e-4));
  Search search;

  // Start 0 is the user's, or the scene's own scale where nothing better is known.
  const std::size_t wanted = static_cast<std::size_t>(options.multi_starts);
  const bool guessed = !unknowns.problem().start.empty();
  std::vector<Eigen::VectorXd> starts, reserve;
  if (wanted == 1 || guessed) starts.push_back(unknowns.z(unknowns.first_guess()));
  if (wanted > 1) {
    search.sample = screen(residuals, options.threads);
    // Descents on tracks cost much: further ones only while chi^2 asks for them.
    const std::size_t at_first =
        unknowns.problem().trajectory_runs.empty() ? wanted : std::min(wanted, kTracks);
    for (const auto& point : basins(unknowns, search.sample))
      (starts.size() < at_first ? starts : reserve).push_back(point.z);
  }
  if (starts.empty()) starts.push_back(unknowns.z(unknowns.first_guess()));

  std::vector<int> hits;
  const auto keep = [&](const Minimum& minimum) {
    ++search.starts;
    if (!std::isfinite(minimum.chi2) || minimum.abandoned) return;
    for (std::size_t i = 0; i < search.minima.size(); ++i)
      if (same(unknowns, search.minima[i], minimum, residuals.excess(search.minima[i].chi2))) {
        ++hits[i];
        if (minimum.chi2 < search.minima[i].chi2 && !minimum.joined)
          search.minima[i] = linearised(rough, minimum);
        return;
      }
    search.minima.push_back(linearised(rough, minimum));
    hits.push_back(1);
  };
  // The most promising start finds the minimum that most others then join early.
  const std::size_t first = starts.size() > 1 && guessed ? 1 : 0;
  MinimiseOptions descent;
  descent.decrement = kRoughDecrement;
  Stage stage(options, "starts", starts.size());
  keep(minimise(rough, starts[first], descent));
  stage.done();
  starts.erase(starts.begin() + static_cast<std::ptrdiff_t>(first));
  const auto descend_from = [&](const std::vector<Eigen::VectorXd>& places, Stage& told) {
    std::vector<Minimum> found(places.size());
    const std::vector<Minimum> known = search.minima;
    descent.known = known.empty() ? nullptr : &known;
    parallel_for(places.size(), options.threads, [&](std::size_t i) {
      found[i] = minimise(rough, places[i], descent);
      told.done();
    });
    for (const Minimum& minimum : found) keep(minimum);
  };
  descend_from(starts, stage);
  // While chi^2 rejects the best minimum, the next points are tried as well.
  const auto surprising = [&] {
    double lowest = HUGE_VAL;
    for (const Minimum& known : search.minima) lowest = std::min(lowest, known.chi2);
    return !(residuals.p_value(lowest) >= kSurprise);
  };
  Stage further(options, "further starts",
                std::min(reserve.size(), wanted - std::min(wanted, starts.size() + 1)));
  for (std::size_t k = 0; k < reserve.size() && search.starts < static_cast<int>(wanted) && surprising();
       k += 2)
    descend_from({reserve.begin() + static_cast<std::ptrdiff_t>(k),
                  reserve.begin() + static_cast<std::ptrdiff_t>(std::min(k + 2, reserve.size()))},
                 further);

  std::vector<std::size_t> order(search.minima.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return search.minima[a].chi2 < search.minima[b].chi2;
  });
  const auto raises = [&](std::size_t i) { return !admissible(unknowns, search.minima[i].z); };
  if (!std::all_of(order.begin(), order.end(), raises)) std::erase_if(order, raises);
  std::vector<Minimum> sorted;
  for (const std::size_t i : order) sorted.push_back(search.minima[i]);
  if (!order.empty()) search.at_best = hits[order.front()];
  search.minima = std::move(sorted);
  return search;
}

}  // namespace tribotrack::fit::internal
