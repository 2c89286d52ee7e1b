// What the layered pass will look at again is kept while the first pass has it decoded.
#pragma once

#include <cstdint>

#include "vision/camera/frame_cache.h"

namespace tribotrack::vision {

/// Of every frame in which the part is seen a window about it, and whole those that the layers are learnt
/// from where they are `likely` to be wanted. Recordings that are not decoded cost nothing.
class LayeredKeeping {
 public:
  /// `first_index` and `total` of the frames analysed.
  LayeredKeeping(KeptFrames& frames, std::int64_t first_index, std::int64_t total, double radius, double blur,
                 bool likely);
  void seen(std::int64_t index, const Point& centre);

 private:
  KeptFrames& frames_;
  std::int64_t first_index_, total_;
  double reach_;
  bool whole_;
};

}  // namespace tribotrack::vision
