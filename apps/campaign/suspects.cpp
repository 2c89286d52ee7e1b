#include "apps/campaign/suspects.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "fit/estimate.h"

namespace tribotrack::apps {

namespace {

/// The farthest that the part gets from where it was first seen.
double way_of(const fit::TrackTable& track) {
  double way = 0;
  for (const auto& position : track.position) way = std::max(way, (position - track.position.front()).norm());
  return way;
}

std::vector<std::string> no_slides(const fit::Problem& problem, const fit::FitResult& result) {
  constexpr double kShare = 0.1;
  std::vector<std::string> sentences;
  for (const fit::RunResult& fitted : result.runs) {
    const auto run = std::ranges::find(problem.trajectory_runs, fitted.name, &fit::TrajectoryRun::name);
    if (run == problem.trajectory_runs.end() || !run->free_slide ||
        fitted.rms_m < kShare * way_of(run->track))
      continue;
    sentences.push_back(fmt::format(
        "run \"{}\" is given as kind = \"free_slide\", but its points lie {:.2g} mm off the slide: is it the "
        "recording of a driven run, or do `frames` hold more than the slide?",
        fitted.name, 1e3 * fitted.rms_m));
  }
  return sentences;
}

/// chi^2 of the data's own sigma.
double chi2_of(const fit::Problem& problem, int threads) {
  fit::FitOptions quick;
  quick.threads = threads;
  quick.multi_starts = 4;
  quick.profiles = quick.next_experiment = quick.estimate_scatter = false;
  try {
    return fit::estimate(problem, quick).chi2_before_scatter;
  } catch (const std::exception&) {  // no motion, or no start, under exchanged labels
    return std::numeric_limits<double>::infinity();
  }
}

/// What two runs may have of each other.
enum class Label { phi, phi_and_dtau };

/// False where that changes nothing, or what the other exchange changes.
bool exchange(model::Friction& one, model::Friction& other, Label label) {
  const bool phi = one.phase != other.phase, dtau = one.pulse_width != other.pulse_width;
  if (label == Label::phi ? !phi || !dtau : !phi && !dtau) return false;
  std::swap(one.phase, other.phase);
  if (label == Label::phi_and_dtau) std::swap(one.pulse_width, other.pulse_width);
  return true;
}

struct Exchange {
  double chi2 = 0;
  std::string runs;  ///< "b" and "d", with what they exchange
};

/// All pairs, the best first.
std::vector<Exchange> exchanges(const fit::Problem& problem, int threads) {
  std::vector<Exchange> found;
  const auto& runs = problem.summary_runs;
  for (std::size_t i = 0; i < runs.size(); ++i)
    for (std::size_t k = i + 1; k < runs.size(); ++k)
      for (const Label label : {Label::phi_and_dtau, Label::phi}) {
        fit::Problem exchanged = problem;
        if (!exchange(exchanged.summary_runs[i].scenario.friction,
                      exchanged.summary_runs[k].scenario.friction, label))
          continue;
        found.push_back({chi2_of(exchanged, threads),
                         fmt::format("\"{}\" and \"{}\" (with {} exchanged)", runs[i].name, runs[k].name,
                                     label == Label::phi ? "phi_rad" : "phi_rad and dtau_rad")});
      }
  std::ranges::sort(found, {}, &Exchange::chi2);
  return found;
}

/// Half a turn more of lag undoes some exchanges: up to two may explain the data alike.
std::vector<std::string> exchanged_labels(const fit::Problem& problem, double chi2, int threads) {
  constexpr std::size_t kFewest = 3, kMost = 6, kAlike = 2;
  constexpr double kMuchBetter = 100, kClear = 10;
  const std::size_t runs = problem.summary_runs.size();
  if (runs < kFewest || runs > kMost || !problem.trajectory_runs.empty()) return {};
  const std::vector<Exchange> found = exchanges(problem, threads);
  if (found.empty() || !(kMuchBetter * found.front().chi2 < chi2)) return {};
  const double clear = kClear * found.front().chi2;
  const auto alike = static_cast<std::size_t>(
      std::ranges::count_if(found, [&](const Exchange& exchange) { return exchange.chi2 < clear; }));
  if (alike > kAlike) return {};
  return {fmt::format(
      "runs {}{} seem to bear each other's label: chi2 then falls from {:.3g} to {:.3g}; check which "
      "recording is which",
      found[0].runs, alike == kAlike ? ", or " + found[1].runs : "", chi2, found.front().chi2)};
}

}  // namespace

std::vector<std::string> suspicious_runs(const fit::Problem& problem, const fit::FitResult& result,
                                         int threads) {
  if (result.usable()) return {};
  std::vector<std::string> sentences = no_slides(problem, result);
  for (std::string& sentence : exchanged_labels(problem, result.chi2_before_scatter, threads))
    sentences.push_back(std::move(sentence));
  return sentences;
}

}  // namespace tribotrack::apps
