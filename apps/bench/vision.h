// Error against run time of sub-pixel tracking, ours and the methods of others, over the grid of what
// recordings are like, on rendered scenes with exactly known truth.
// Measurements of this machine now: the times, not the errors, change from call to call.
#pragma once

#include <filesystem>
#include <functional>
#include <vector>

#include "apps/bench/comparison.h"

namespace tribotrack::bench {

/// A recording on which `track` is timed as a whole command.
struct WholeCommands {
  std::filesystem::path program;  ///< tribotrack; empty: none is timed
  int width = 1280, height = 800;
  double radius = 60;  ///< px
  int frames = 405;
};

struct VisionBenchOptions {
  std::vector<double> radii{10, 30, 60, 150, 200};  ///< px
  std::vector<double> textures{0, 5, 10, 20};       ///< of the platform, grey levels rms
  std::vector<double> noises{1, 3, 8};              ///< grey levels, the 1/12 of rounding not included
  int frames = 1050;                                ///< of a recording
  WholeCommands whole;
  std::function<void(int done, int total)> progress;
};
/// A few frames of one small disc: shows that it works.
VisionBenchOptions quick_vision_options();

/// A disc (170 grey levels, edge blur 0.7 px) goes round by 3.7 px over a platform (80 grey levels) that goes
/// round by 5.6 px, with a marker; one without texture rests. 8 bits. 125 poses, rendered analytically, come
/// again with new noise. Ours is `track` as users get it, learning included; the peers are
/// told where part and marker lie. The error is the rms over the Cramer-Rao bound with everything but the
/// position known, the time that of one thread a frame. Details: rms_px, bound_px, lost, components (two for
/// each frame that counts) and, of ours, standardised (rms of the errors over their own standard deviations:
/// 1 where these are true) and layered (what the plan chose); of others these are NaN. The last rows are
/// whole commands over a plain and a textured platform.
Comparison bench_vision(const VisionBenchOptions& options = {});

}  // namespace tribotrack::bench
