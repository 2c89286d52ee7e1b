#include "fit/minimum/multi_start.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "fit/tools/stage_progress.h"
#include "model/alpha_v.h"
#include "model/parallel.h"

namespace tribotrack::fit::internal {

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

namespace {

/// Distinct minima of residuals, and how many descents ended in each.
class Minima {
 public:
  explicit Minima(const Residuals& residuals) : residuals_(residuals) {}

  void keep(const Minimum& minimum) {
    if (!std::isfinite(minimum.chi2) || minimum.abandoned) return;
    for (Minimum& known : found_)
      if (same(residuals_.unknowns(), known, minimum, residuals_.excess(known.chi2))) {
        const int together = known.descents + minimum.descents;
        if (minimum.chi2 < known.chi2 && !minimum.joined) known = linearised(residuals_, minimum);
        known.descents = together;
        return;
      }
    found_.push_back(linearised(residuals_, minimum));
  }
  /// From these places, in whose order they are kept; into each so many led before.
  void descend_from(const std::vector<Eigen::VectorXd>& places, int threads, Stage& told,
                    const std::vector<int>& descents = {}) {
    const std::vector<Minimum> known = found_;
    constexpr double kRoughDecrement = 0.01;  ///< a tenth of a standard deviation
    const MinimiseOptions rough{.decrement = kRoughDecrement, .known = known.empty() ? nullptr : &known};
    std::vector<Minimum> ends(places.size());
    parallel_for(places.size(), threads, [&](std::size_t i) {
      ends[i] = minimise(residuals_, places[i], rough);
      told.done();
    });
    for (std::size_t i = 0; i < ends.size(); ++i) {
      if (!descents.empty()) ends[i].descents = descents[i];
      keep(ends[i]);
    }
  }
  /// Best first. One in which pulses raise friction counts where there is no other.
  void sort() {
    std::ranges::stable_sort(found_, {}, &Minimum::chi2);
    const auto raises = [&](const Minimum& m) { return !admissible(residuals_.unknowns(), m.z); };
    if (!std::ranges::all_of(found_, raises)) std::erase_if(found_, raises);
  }
  const std::vector<Minimum>& found() const { return found_; }

 private:
  const Residuals& residuals_;
  std::vector<Minimum> found_;
};

/// So few summary runs that a fit to them is quick, the tracks, and what all share.
Problem thinned(Problem problem) {
  keep_representative(problem.summary_runs, kRunsToSearch);
  return problem;
}

bool guessed(const Unknowns& unknowns) {
  return !unknowns.problem().start.empty();
}

/// Start 0 is the user's, or the scene's own scale where nothing better is known; the others are basins of so
/// many points, which the search keeps.
std::vector<Eigen::VectorXd> starts_of(Search& search, const Residuals& residuals, const FitOptions& options,
                                       std::size_t points) {
  const Unknowns& unknowns = residuals.unknowns();
  const std::size_t wanted = static_cast<std::size_t>(options.multi_starts);
  std::vector<Eigen::VectorXd> starts;
  if (wanted == 1 || guessed(unknowns)) starts.push_back(unknowns.z(unknowns.first_guess()));
  if (wanted > 1) {
    search.sample = screen(residuals, options.threads, points);
    for (const auto& point : basins(unknowns, search.sample, refinable(residuals)))
      if (starts.size() < wanted) starts.push_back(point.z);
  }
  if (starts.empty()) starts.push_back(unknowns.z(unknowns.first_guess()));
  return starts;
}

}  // namespace

Search multi_start(const Residuals& residuals, const FitOptions& options) {
  const Unknowns& unknowns = residuals.unknowns();
  Residuals rough = residuals;
  rough.set_tolerance(residuals.tolerance_for(0.3, 1e-4));
  Search search;

  // Where the valleys are a part of many runs tells.
  const std::size_t wanted = static_cast<std::size_t>(options.multi_starts);
  const bool many = wanted > 1 && unknowns.problem().summary_runs.size() > kRunsToSearch;
  const Problem few = many ? thinned(unknowns.problem()) : Problem{};
  const std::optional<Unknowns> unknowns_of_few = many ? std::optional<Unknowns>(few) : std::nullopt;
  std::optional<Residuals> residuals_of_few;
  if (many) {
    const Eigen::VectorXd guess = unknowns_of_few->first_guess();
    residuals_of_few.emplace(*unknowns_of_few, options.threads);
    residuals_of_few->set_tolerance(residuals.tolerance_for(0.3, 1e-4));
    residuals_of_few->set_own_errors(guess);
  }
  Residuals& searched = many ? *residuals_of_few : rough;
  std::vector<Minimum> found;
  constexpr double kRejected = 1e-3;
  // Points of the box; the latter where the lowest minimum that the former lead to is rejected.
  for (const std::size_t points : {250U, 2000U}) {
    const std::size_t before = search.sample.size();
    std::vector<Eigen::VectorXd> starts = starts_of(search, residuals, options, points);
    if (search.sample.size() == before && search.starts > 0) break;
    for (const Minimum& known : found) starts.push_back(known.z);
    // The most promising start finds the minimum that most others then join early.
    const std::size_t first = starts.size() > 1 && guessed(unknowns) ? 1 : 0;
    if (!searched.linearise(unknowns.values(starts[first]))) searched.linearise(unknowns.first_guess());
    Minima minima(searched);
    Stage stage(options, "starts", starts.size());
    minima.descend_from({starts[first]}, 1, stage);
    search.starts += static_cast<int>(starts.size());
    starts.erase(starts.begin() + static_cast<std::ptrdiff_t>(first));
    minima.descend_from(starts, options.threads, stage);
    minima.sort();
    found = minima.found();
    if (!found.empty() && !(searched.p_value(found.front().chi2) < kRejected)) break;
  }
  Minima of_all(rough);
  if (many) {
    std::vector<Eigen::VectorXd> places;
    std::vector<int> descents;
    for (const Minimum& minimum : found) {
      places.push_back(minimum.z);
      descents.push_back(minimum.descents);
    }
    if (!places.empty()) rough.linearise(unknowns.values(places.front()));
    Stage refined(options, "minima", places.size());
    of_all.descend_from(places, options.threads, refined, descents);
    of_all.sort();
  }
  search.minima = many ? of_all.found() : std::move(found);
  if (!search.minima.empty()) search.at_best = search.minima.front().descents;
  return search;
}

}  // namespace tribotrack::fit::internal
