// What work costs as it grows: whole commands on ever larger inputs, and the exponent of each cost.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace tribotrack::bench {

struct ScaleOptions {
  /// Of each series, growing. Up to these a bench ends within some minutes.
  std::vector<int> recordings = {10, 30, 100, 300};     ///< of a campaign, `run`; 75 frames of 128 x 128 each
  std::vector<int> frames = {300, 1000, 3000, 10'000};  ///< of one recording of 128 x 128, `track`
  std::vector<int> runs = {10, 30, 100, 300};           ///< of alpha and v in a table, `fit`
  std::vector<int> points = {300, 1000, 3000, 10'000};  ///< of one track, `fit` with data = "trajectory"
  std::vector<int> sweep = {1000, 10'000, 100'000, 1'000'000};  ///< scenarios, `sweep`
  std::filesystem::path program;                                ///< tribotrack
  std::filesystem::path folder;  ///< for inputs and outputs; empty: a temporary one
  std::function<void(int done, int total)> progress;
};
/// Seconds in all: a check that it works.
ScaleOptions quick_scale_options();
/// 1000 recordings, 1e6 frames and points, 3000 runs, 1e7 scenarios: half an hour, 20 GB of disk.
ScaleOptions full_scale_options();

/// One command on one size.
struct ScaleRow {
  std::string series;  ///< "recordings", "frames", "runs", "points", "scenarios"
  int size = 0;
  double cpu = 0;     ///< s, of all threads; one thread is used
  double wall = 0;    ///< s
  double memory = 0;  ///< bytes resident at most
  /// System calls that look up files by name or list folders, counted by strace; nothing where it is not
  /// installed, and for commands of over a minute.
  std::optional<double> file_calls;
};

/// cost ~ size^exponent over the larger sizes.
struct ScaleExponent {
  std::string series, cost;  ///< of "cpu", "memory", "file calls"
  int from = 0, to = 0;      ///< sizes
  double exponent = 0;
  double sd = 0;  ///< from the scatter about the line; 0 for two sizes
};

/// Throws std::runtime_error, with what the command said, where one fails.
std::vector<ScaleRow> bench_scale(const ScaleOptions& options);

/// Of each series and cost, by least squares on the logarithms of its three largest sizes: below them what
/// does not grow, such as starting the program, hides what does.
std::vector<ScaleExponent> exponents(const std::vector<ScaleRow>& rows);

}  // namespace tribotrack::bench
