// What does a user wait for? `tribotrack track` from the start of its process to its end, beside others'
// whole commands on the same recordings: learning, looking for the disc, hashing and starting are fixed costs
// that a recording of a few hundred frames does not spread.
//
// Ours is `track RECORDING --marker X,Y,R -o T.csv`, which finds the disc by itself. The peers are told where
// part and mark lie in the first frame; they are processes of the same program, so that loading it and its
// libraries counts alike, and read through the same code. All of them take turns, a recording at a time, from
// the system's cache; OpenCV and libav keep to one thread.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "apps/bench/vision/command_shares.h"

namespace tribotrack::bench {

struct WholeCommandOptions {
  std::filesystem::path program;  ///< the tribotrack to start, peers included
  std::vector<int> frames = {100, 500, 2000};
  std::vector<double> diameters = {60, 120, 300};  ///< of the disc, px
  int width = 1280, height = 800;                  ///< px; halved for recordings of more than kManyFrames
  int repetitions = 5;                             ///< at most; at least 3 (or so many), within budget_s
  double budget_s = 60;                            ///< wall time of one recording in one coding
  /// Where recordings are kept, and taken from where they are there. Empty: temporary ones, removed.
  std::filesystem::path keep;
  std::function<void(int done, int total)> progress;
};
/// Pictures of 1280 x 800 would take 20 GB uncompressed.
inline constexpr int kManyFrames = 5000;

/// A few small pictures: shows that it works.
WholeCommandOptions quick_whole_command_options();

/// One way to call `track` on one recording (circling.h).
struct WholeCommandRow {
  std::string coding;  ///< "cine" (uncompressed), "h264"
  bool brushed = false;
  double diameter = 0;  ///< px
  int width = 0, height = 0;
  int frames = 0;
  bool layers_off = false;  ///< called with --layers off
  bool layered = false;     ///< what the plan chose
  int repetitions = 0;
  int lost = 0;
  double rms = 0;               ///< px per coordinate, mean offset removed
  double matching_rms = 0;      ///< likewise, of the peer
  double cpu = 0;               ///< s, medians of the repetitions: one thread, user and system
  double wall = 0;              ///< s, one thread
  double wall_two_threads = 0;  ///< s, --threads 2
  double cpu_two_threads = 0;   ///< s
  double matching = 0;          ///< s CPU: windowed cv::matchTemplate with a parabola (command_peers.h)
  double reading = 0;           ///< s CPU: the same windows read or decoded, and nothing else
  CommandShares shares;
};

/// Throws vision::InputError where recordings cannot be written or there is no room for them,
/// std::runtime_error with what it said where a command fails.
std::vector<WholeCommandRow> bench_whole_commands(const WholeCommandOptions& options);

}  // namespace tribotrack::bench
