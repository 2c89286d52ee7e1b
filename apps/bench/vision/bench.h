// Error against run time of sub-pixel tracking, ours and the methods of others, on rendered scenes with
// exactly known truth. Measurements of this machine now: the times, not the errors, change from call to call.
#pragma once

#include <functional>
#include <string>
#include <vector>

namespace tribotrack::bench {

struct VisionBenchOptions {
  bool quick = false;  ///< one small disc, few frames: a check that it works
  std::function<void(int done, int total)> progress;
};

/// One method on one scene. A disc (contrast 90 grey levels, edge blur 0.7 px) goes round on a path of 3.7 px
/// radius that drifts through all fractions of a pixel; 8 bits, white noise.
struct VisionBenchRow {
  std::string scene;  ///< "plain" or "brushed, moving": texture of 10 grey levels rms going round by 5.6 px
  double radius = 0;  ///< px
  double noise = 0;   ///< grey levels, the 1/12 of rounding not included
  std::string method;
  bool ours = false;
  int frames = 0;
  int lost = 0;             ///< frames without a position
  double rms = 0;           ///< px per coordinate, mean offset removed
  double bound = 0;         ///< px, Cramer-Rao bound with everything but the position known
  double offset = 0;        ///< px, length of the mean offset from the truth
  double peak_locking = 0;  ///< px, amplitude of the sine of the fraction of a pixel fitted to the error
  double time = 0;  ///< s per frame, CPU time of one thread; median, methods taking turns on each frame
  double rms_over_ours = 0;   ///< against "tribotrack track"; below 1 the peer is more accurate
  double time_over_ours = 0;  ///< likewise; below 1 the peer is faster
};

/// Ours: `track` (the whole pipeline from opened source to track) and its registration alone. Peers:
/// cv::matchTemplate (NCC, square template) with a parabola or a Gaussian through three points,
/// cv::phaseCorrelate, the grey centroid about Otsu's threshold. Decoding is left out for all.
std::vector<VisionBenchRow> bench_vision(const VisionBenchOptions& options = {});

}  // namespace tribotrack::bench
