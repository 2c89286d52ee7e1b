// Learning the part's pictures from kept windows: which pictures, and where in each window?
//
// Each round learns the pictures from the windows in their present states, then measures the windows over
// them, until the windows hardly move.
#pragma once

#include <vector>

#include "vision/layers/model/light.h"
#include "vision/layers/registration/registration.h"
#include "vision/stages/first_pass_result.h"

namespace tribotrack::vision {

struct LearntPart {
  PartPictures part;
  IlluminationSlope light;
  double chi_squared = 1;  ///< per pixel, of the usual window
  double sigma = 0;        ///< of a coordinate of the usual window, px
  int rounds = 0;
  std::size_t explained = 0;  ///< windows
};

/// Changes the windows' states, and tells the ground what is seen of it beside the part: within `hidden` px
/// of the part none has been seen yet. The result is the same for any number of threads. `registration` is
/// left with the pictures learnt.
LearntPart learn_part(std::vector<KeptWindow>& windows, GroundPicture& ground,
                      LayeredRegistration& registration, const FirstPassResult& first, double hidden,
                      int threads);

}  // namespace tribotrack::vision
