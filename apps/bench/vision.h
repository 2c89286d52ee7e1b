// Error against run time of sub-pixel tracking, ours and the methods of others, over the grid of what
// recordings are like, on rendered scenes with exactly known truth; and whole commands on recordings on disk.
// Measurements of this machine now: the times, not the errors, change from call to call.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <vector>

#include "apps/bench/comparison.h"
#include "vision/frame_source.h"
#include "vision/synthesis/camera.h"

namespace tribotrack::bench {

struct VisionBenchOptions {
  std::vector<double> radii{10, 30, 60, 150, 200};  ///< px
  std::vector<double> textures{0, 5, 10, 20};       ///< of the platform, grey levels rms
  std::vector<double> noises{1, 3, 8};              ///< grey levels, the 1/12 of rounding not included
  int frames = 1050;                                ///< of a recording
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
/// 1 where these are true) and layered (what the plan chose); of others these are NaN.
Comparison bench_vision(const VisionBenchOptions& options = {});

struct WholeCommandOptions {
  std::filesystem::path program;   ///< the tribotrack to start
  int width = 1280, height = 800;  ///< px
  double radius = 60;              ///< px
  int frames = 500;
  int repetitions = 5;
};
/// A few small pictures: shows that it works.
WholeCommandOptions quick_whole_command_options();

/// What a user waits for: CPU time of a `track` process on a recording, uncompressed and H.264, from its
/// start to its end, beside that of following part and marker in the same file by cv::matchTemplate, in this
/// process; they take turns. The times are those of one thread, a frame. Throws vision::InputError where
/// recordings cannot be written, std::runtime_error where the command fails.
std::vector<ComparedRow> bench_whole_commands(const WholeCommandOptions& options);

/// A picture as an 8-bit camera records it: white noise of `noise` grey levels, then rounding and clipping.
inline vision::Picture recorded(const vision::Picture& exact, double noise, std::uint64_t frame) {
  const vision::CounterRandom random(20210, frame);
  vision::Picture out = exact;
  std::uint64_t counter = 0;
  for (float& level : out.levels())
    level =
        std::clamp(std::round(level + static_cast<float>(noise) * random.gaussian(counter++)), 0.0F, 255.0F);
  return out;
}

/// Every benchmark's recording runs at this frame rate, Hz.
inline constexpr double kFrameRate = 1000;

// How others follow a disc to a fraction of a pixel: for comparison only (`tribotrack bench vision`).

/// Follows each target (the part, then the marker) by cv::matchTemplate in a window about its last position,
/// with a parabola between pixels; the template is its square in the first frame. `targets` are given where
/// they lie in the first frame, to the fraction of a pixel. Returns the positions of the first one, px.
std::vector<vision::Point> follow_by_matching(vision::FrameSource& source,
                                              const std::vector<vision::Circle>& targets);

/// Follows each target by a circle through the points of steepest grey level along rays from its last
/// position (Kasa's fit: linear least squares), three times in each frame, the last two without edges that
/// lie beside it.
std::vector<vision::Point> follow_by_circle_fit(vision::FrameSource& source,
                                                const std::vector<vision::Circle>& targets);

}  // namespace tribotrack::bench
