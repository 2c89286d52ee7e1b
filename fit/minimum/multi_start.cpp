#include "fit/minimum/multi_start.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "fit/minimum/screen.h"
#include "fit/tools/stage_progress.h"
#include "fit/tools/statistics.h"
#include "model/alpha_v.h"
#include "model/parallel.h"

namespace tribotrack::fit::internal {
namespace {

constexpr std::size_t kTracks = 6;  ///< basins that a fit to tracks, whose descents cost much, looks into
constexpr double kRoughDecrement = 0.01;  ///< a tenth of a standard deviation
constexpr std::size_t kRunsToSearch = 24;

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

namespace {

/// Distinct minima of residuals, and how many descents ended in each.
class Minima {
 public:
  explicit Minima(const Residuals& residuals) : residuals_(residuals) {}

  void keep(const Minimum& minimum, int descents = 1) {
    if (!std::isfinite(minimum.chi2) || minimum.abandoned) return;
    for (std::size_t i = 0; i < found_.size(); ++i)
      if (same(residuals_.unknowns(), found_[i], minimum, residuals_.excess(found_[i].chi2))) {
        hits_[i] += descents;
        if (minimum.chi2 < found_[i].chi2 && !minimum.joined) found_[i] = linearised(residuals_, minimum);
        return;
      }
    found_.push_back(linearised(residuals_, minimum));
    hits_.push_back(descents);
  }
  /// From these places, in whose order they are kept.
  void descend_from(const std::vector<Eigen::VectorXd>& places, int threads, Stage& told,
                    const std::vector<int>& descents = {}) {
    MinimiseOptions rough;
    rough.decrement = kRoughDecrement;
    const std::vector<Minimum> known = found_;
    if (!known.empty()) rough.known = &known;
    std::vector<Minimum> ends(places.size());
    parallel_for(places.size(), threads, [&](std::size_t i) {
      ends[i] = minimise(residuals_, places[i], rough);
      told.done();
    });
    for (std::size_t i = 0; i < ends.size(); ++i) keep(ends[i], descents.empty() ? 1 : descents[i]);
  }
  /// Best first. One in which pulses raise friction counts where there is no other.
  void sort() {
    std::vector<std::size_t> order(found_.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return found_[a].chi2 < found_[b].chi2; });
    const auto raises = [&](std::size_t i) { return !admissible(residuals_.unknowns(), found_[i].z); };
    if (!std::all_of(order.begin(), order.end(), raises)) std::erase_if(order, raises);
    std::vector<Minimum> found;
    std::vector<int> hits;
    for (const std::size_t i : order) {
      found.push_back(found_[i]);
      hits.push_back(hits_[i]);
    }
    found_ = std::move(found);
    hits_ = std::move(hits);
  }
  const std::vector<Minimum>& found() const { return found_; }
  const std::vector<int>& hits() const { return hits_; }

 private:
  const Residuals& residuals_;
  std::vector<Minimum> found_;
  std::vector<int> hits_;
};

/// So few summary runs that a fit to them is quick, the tracks, and what all share.
Problem thinned(Problem problem) {
  keep_representative(problem.summary_runs, kRunsToSearch);
  return problem;
}

}  // namespace

Search multi_start(const Residuals& residuals, const FitOptions& options) {
  const Unknowns& unknowns = residuals.unknowns();
  Residuals rough = residuals;
  rough.set_tolerance(residuals.tolerance_for(0.3, 1e-4));
  Search search;

  // Start 0 is the user's, or the scene's own scale where nothing better is known.
  const std::size_t wanted = static_cast<std::size_t>(options.multi_starts);
  const bool guessed = !unknowns.problem().start.empty();
  std::vector<Eigen::VectorXd> starts;
  if (wanted == 1 || guessed) starts.push_back(unknowns.z(unknowns.first_guess()));
  if (wanted > 1) {
    search.sample = screen(residuals, options.threads);
    const std::size_t most = unknowns.problem().trajectory_runs.empty() ? wanted : std::min(wanted, kTracks);
    for (const auto& point : basins(unknowns, search.sample))
      if (starts.size() < most) starts.push_back(point.z);
  }
  if (starts.empty()) starts.push_back(unknowns.z(unknowns.first_guess()));

  // Where the valleys are a part of many runs tells.
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
  const std::size_t first = starts.size() > 1 && guessed ? 1 : 0;
  if (!searched.linearise(unknowns.values(starts[first]))) searched.linearise(unknowns.first_guess());
  Minima minima(searched);

  // The most promising start finds the minimum that most others then join early.
  Stage stage(options, "starts", starts.size());
  minima.descend_from({starts[first]}, 1, stage);
  search.starts = static_cast<int>(starts.size());
  starts.erase(starts.begin() + static_cast<std::ptrdiff_t>(first));
  minima.descend_from(starts, options.threads, stage);
  minima.sort();
  Minima of_all(rough);
  if (many) {
    std::vector<Eigen::VectorXd> places;
    for (const Minimum& minimum : minima.found()) places.push_back(minimum.z);
    if (!places.empty()) rough.linearise(unknowns.values(places.front()));
    Stage refined(options, "minima", places.size());
    of_all.descend_from(places, options.threads, refined, minima.hits());
    of_all.sort();
  }
  const Minima& found = many ? of_all : minima;
  search.minima = found.found();
  if (!search.minima.empty()) search.at_best = found.hits().front();
  return search;
}

}  // namespace tribotrack::fit::internal
