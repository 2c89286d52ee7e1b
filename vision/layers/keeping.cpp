#include "vision/layers/keeping.h"

#include "vision/io/window.h"
#include "vision/layers/pass.h"

namespace tribotrack::vision {

LayeredKeeping::LayeredKeeping(KeptFrames& frames, std::int64_t first_index, std::int64_t total,
                               double radius, double blur, bool likely)
    : frames_(frames),
      first_index_(first_index),
      total_(total),
      reach_(layered_reach(radius, blur)),
      whole_(likely) {}

void LayeredKeeping::seen(std::int64_t index, const Point& centre) {
  const bool whole = whole_ && is_learning_frame(index - first_index_, total_);
  frames_.keep(index, whole ? frames_.bounds() : window_about(centre, reach_, frames_.bounds()));
}

}  // namespace tribotrack::vision
