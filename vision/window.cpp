#include "vision/window.h"

#include <stdexcept>
#include <string>

namespace tribotrack::vision {

void prepare_window(const SourceInfo& info, std::int64_t index, const Rect& window, Picture& picture) {
  if (index < 0 || index >= info.frame_count)
    throw std::out_of_range("frame " + std::to_string(index) + " of '" + info.path.string() +
                            "', which has " + std::to_string(info.frame_count));
  if (window.width <= 0 || window.height <= 0 || !Rect{0, 0, info.width, info.height}.contains(window))
    throw std::invalid_argument("window " + std::to_string(window.width) + " x " +
                                std::to_string(window.height) + " at (" + std::to_string(window.x) + ", " +
                                std::to_string(window.y) + ") does not lie in the " +
                                std::to_string(info.width) + " x " + std::to_string(info.height) +
                                " picture of '" + info.path.string() + "'");
  if (picture.width() != window.width || picture.height() != window.height)
    picture = Picture(window.width, window.height);
}

}  // namespace tribotrack::vision
