#include "vision/formats/threads.h"

#include <opencv2/core/utility.hpp>

namespace tribotrack::vision {

void keep_to_calling_thread() {
  cv::setNumThreads(1);
}

}  // namespace tribotrack::vision
