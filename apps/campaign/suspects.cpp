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
enum class Label { phi, dtau, both };

/// False where that changes nothing, or nothing that another exchange does not.
bool exchange(model::Friction& one, model::Friction& other, Label label) {
  const bool phi = one.phase != other.phase, dtau = one.pulse_width != other.pulse_width;
  if (!phi && !dtau) return false;
  if (label != Label::both && !(phi && dtau)) return false;
  if (label != Label::dtau) std::swap(one.phase, other.phase);
  if (label != Label::phi) std::swap(one.pulse_width, other.pulse_width);
  return true;
}

const char* names_of(Label label) {
  return label == Label::phi ? "phi_rad" : label == Label::dtau ? "dtau_rad" : "phi_rad and dtau_rad";
}

std::vector<std::string> exchanged_labels(const fit::Problem& problem, double chi2, int threads) {
  constexpr std::size_t kMostRuns = 8;
  constexpr double kMuchBetter = 100, kClear = 10;
  const std::size_t runs = problem.summary_runs.size();
  if (runs < 3 || runs > kMostRuns || !problem.trajectory_runs.empty()) return {};
  double best = std::numeric_limits<double>::infinity(), second = best;
  std::string sentence;
  for (std::size_t i = 0; i < runs; ++i)
    for (std::size_t k = i + 1; k < runs; ++k)
      for (const Label label : {Label::both, Label::phi, Label::dtau}) {
        fit::Problem exchanged = problem;
        if (!exchange(exchanged.summary_runs[i].scenario.friction,
                      exchanged.summary_runs[k].scenario.friction, label))
          continue;
        const double found = chi2_of(exchanged, threads);
        second = std::min(second, std::max(best, found));
        if (!(found < best)) continue;
        best = found;
        sentence = fmt::format(
            "runs \"{}\" and \"{}\" seem to bear each other's label: with their {} exchanged chi2 falls from "
            "{:.3g} to "
            "{:.3g}; check which recording is which",
            problem.summary_runs[i].name, problem.summary_runs[k].name, names_of(label), chi2, best);
      }
  if (!(best * kMuchBetter < chi2 && best * kClear < second)) return {};
  return {sentence};
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
