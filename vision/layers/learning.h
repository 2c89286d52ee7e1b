// Learning the part's pictures from kept windows: which pictures, and where in each window?
//
// Each round learns the pictures from the windows in their present states, then measures the windows over
// them, until the windows hardly move.
#pragma once

#include <vector>

#include "vision/layers/registration.h"

namespace tribotrack::vision {

struct LearntPart {
  PartPictures part;
  LightPrior light;
  double chi_squared = 1;  ///< per pixel, of the usual window
  double sigma = 0;        ///< of a coordinate of the usual window, px
  int rounds = 0;
  std::size_t explained = 0;  ///< windows
};

/// Changes the windows' states. `registration` is left with the pictures learnt.
LearntPart learn_part(std::vector<KeptWindow>& windows, const GroundPicture& ground,
                      LayeredRegistration& registration, double radius, double blur, double noise_variance);

}  // namespace tribotrack::vision
