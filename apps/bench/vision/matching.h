// How others find a disc to a fraction of a pixel: for comparison only (`tribotrack bench vision`).
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "vision/picture.h"

namespace tribotrack::bench {

/// Finds the disc in pictures of one size. Prepared once with the first picture and the disc in it.
class PositionMethod {
 public:
  virtual ~PositionMethod() = default;
  virtual std::string name() const = 0;
  /// Converts a picture into the form the method takes; not part of the method's time.
  virtual void take(const vision::Picture& picture) = 0;
  /// The disc's centre in the picture taken last, px.
  virtual vision::Point locate() = 0;
};

/// Those built on OpenCV (bench_vision limits OpenCV to one thread).
std::vector<std::unique_ptr<PositionMethod>> peer_position_methods(const vision::Picture& first,
                                                                   const vision::Circle& disc);

/// The first of them: cv::matchTemplate with a parabola through three points along each axis.
std::unique_ptr<PositionMethod> match_template(const vision::Picture& first, const vision::Circle& disc);
/// How far its square template reaches from the pixel nearest to the disc's centre, px.
int template_reach(const vision::Circle& disc);

/// Sets the number of OpenCV's threads; returns the number before.
int set_opencv_threads(int count);

}  // namespace tribotrack::bench
