// A quieter template: the first frames laid on each other.
//
// The noise of a single template goes into its derivatives, which costs accuracy, and into the residual at
// every fraction of a pixel anew. Averaged over M frames aligned with the first it has 1/M of that variance.
// It is never replaced afterwards: a replaced template drifts.
#pragma once

#include <cstdint>

#include "vision/following/pattern_follower.h"
#include "vision/frame_source.h"
#include "vision/registration/pattern.h"

namespace tribotrack::vision {

struct TemplateAverageOptions {
  int frames = 24;             ///< at most, the first included
  double score_share = 0.985;  ///< of the first matches' median score: lower ones show something else
};

struct AveragedTemplate {
  Picture averaged;  ///< the first frame with the template's surroundings averaged; empty for one frame alone
  int frames = 1;    ///< M
  const Picture& picture(const Picture& first) const { return averaged.empty() ? first : averaged; }
};

/// Follows the pattern through the frames after `index` (up to `last`) with the single template and averages
/// what it finds. The part must not turn. One frame alone where fewer than four match.
AveragedTemplate average_template(FrameSource& source, const Picture& first, std::int64_t index,
                                  std::int64_t last, const Pattern& pattern, const FollowOptions& follow,
                                  const TemplateAverageOptions& options = {});

}  // namespace tribotrack::vision
