// Learning the part's pictures from kept windows: which pictures, and where in each window?
//
// Each round learns the pictures from the windows in their present states, then measures the windows over
// them, until the windows hardly move.
#pragma once

#include <memory>
#include <vector>

#include "vision/layers/model/light.h"
#include "vision/layers/registration/registration.h"

namespace tribotrack::vision {

/// Where a few windows have led: what further candidates begin with.
struct LearningStart {
  std::vector<LayeredState> states;  ///< of all windows
  PartPictures part;
};

struct LearntPart {
  PartPictures part;
  std::unique_ptr<TurningTexture> texture;  ///< null where nothing turns
  std::unique_ptr<StandingLight> standing;  ///< null where none was looked for
  IlluminationSlope light;
  double standing_evidence = 1;  ///< that light stands in the picture yet, StandingLight::evidence()
  double chi_squared = 1;        ///< per pixel, of the usual window
  double sigma = 0;              ///< of a coordinate of the usual window, px
  int rounds = 0;
  std::size_t explained = 0;  ///< windows
  LearningStart early;        ///< empty where another candidate's was taken
};

struct LearningOptions {
  double radius = 0, blur = 1;           ///< of the rim, px
  double noise_variance = 1;             ///< of the frames
  double hidden = 0;                     ///< px about the part within which no ground has been seen yet
  bool turning = false;                  ///< the windows' angles are known and differ: learn what turns
  bool even_light = false;               ///< do not look for a slope of the light
  bool standing_light = false;           ///< look for light that stands in the picture, beside its slope
  const LearningStart* start = nullptr;  ///< of another candidate without a texture; null: from the beginning
  int threads = 1;                       ///< the result is the same for any number
};

/// Changes the windows' states, and tells the ground what is seen of it beside the part. `registration` is
/// left with the pictures learnt.
LearntPart learn_part(std::vector<KeptWindow>& windows, GroundPicture& ground,
                      LayeredRegistration& registration, const LearningOptions& options);

}  // namespace tribotrack::vision
