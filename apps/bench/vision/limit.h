// How close to the physical limit is the whole tracker, plain and layered, over the grid of what recordings
// are like? And are its standard deviations true?
#pragma once

#include <functional>
#include <vector>

#include "vision/track.h"

namespace tribotrack::bench {

struct VisionLimitOptions {
  std::vector<double> radii{10, 30, 60, 150, 200};  ///< px
  std::vector<double> textures{0, 5, 10, 20};       ///< of the platform, grey levels rms
  std::vector<double> noises{1, 3, 8};              ///< grey levels, the 1/12 of rounding not included
  int frames = 1050;                                ///< of a recording
  std::function<void(int done, int total)> progress;
};

/// A few frames of one small disc: shows that it works.
VisionLimitOptions quick_limit_options();

/// A disc (170 grey levels, edge blur 0.7 px) goes round by 3.7 px over a platform (80 grey levels) that goes
/// round by 5.6 px, with a marker; one without texture rests. 8 bits. 125 poses, rendered analytically, come
/// again with new noise.
struct VisionLimitRow {
  double radius = 0, texture = 0, noise = 0;
  bool layered = false;  ///< what the plan chose
  int components = 0;    ///< errors that were counted: two per frame
  int lost = 0;          ///< frames
  double rms = 0;        ///< px, of the errors' components, mean offset removed
  double bound = 0;      ///< px, Cramer-Rao bound with everything but the position known, rms over the path
  double standardised = 0;  ///< rms of the errors over their own standard deviations: 1 where these are true
  vision::Audit audit;      ///< what the recording itself says of them, before the audit widened them
  double noise_found = 0;   ///< grey levels, rounding included
  double time = 0;          ///< s per frame, CPU time of one thread, learning included
};

std::vector<VisionLimitRow> bench_limit(const VisionLimitOptions& options);

}  // namespace tribotrack::bench
