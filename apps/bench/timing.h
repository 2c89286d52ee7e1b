// Comparable run times: the competitors take turns, so that a change of the machine's load or clock hits them
// alike, and the median of each is reported. CPU time of this thread: the load of other programs does not
// count.
#pragma once

#include <ctime>
#include <functional>
#include <vector>

#include "fit/tools/statistics.h"

namespace tribotrack::bench {

using fit::internal::upper_median;

struct PairedTiming {
  int rounds = 7;
  double budget_s = 1;  ///< of one competitor: a slow one takes part in fewer rounds, at least in one
};

struct MedianTime {
  double seconds = 0;
  int repetitions = 0;
};

inline double thread_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

inline double seconds_of(const std::function<void()>& work) {
  const double begin = thread_seconds();
  work();
  return thread_seconds() - begin;
}

/// Round-robin over the competitors; the first call of each warms up and counts only if it is the only one.
inline std::vector<MedianTime> paired_medians(const std::vector<std::function<void()>>& competitors,
                                              const PairedTiming& options) {
  std::vector<double> first(competitors.size()), spent(competitors.size());
  std::vector<std::vector<double>> times(competitors.size());
  for (std::size_t k = 0; k < competitors.size(); ++k) spent[k] = first[k] = seconds_of(competitors[k]);
  for (int round = 0; round < options.rounds; ++round)
    for (std::size_t k = 0; k < competitors.size(); ++k) {
      if (spent[k] + first[k] > options.budget_s) continue;
      times[k].push_back(seconds_of(competitors[k]));
      spent[k] += times[k].back();
    }
  std::vector<MedianTime> result;
  for (std::size_t k = 0; k < competitors.size(); ++k) {
    if (times[k].empty()) times[k].push_back(first[k]);
    result.push_back({upper_median(times[k]), static_cast<int>(times[k].size())});
  }
  return result;
}

}  // namespace tribotrack::bench
