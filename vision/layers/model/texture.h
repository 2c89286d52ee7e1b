// What turns with the part: scratches and marks on it, on a grid of its own.
#pragma once

#include <span>
#include <vector>

#include "vision/layers/model/ground.h"
#include "vision/layers/model/part.h"
#include "vision/layers/model/state.h"

namespace tribotrack::vision {

/// T(u'), u' = R(-theta) u: added to F over the part's face. F and T can exchange whatever is the same at all
/// angles, which is nobody's: T's mean over every ring is zero. What turns slowly about the centre as a slope
/// is told from a light that changes along the way, and an eccentric rim from a part that moves, only by a
/// part that has turned right round: before that T has no first harmonic and ends before the rim, whose
/// roundness ties the centre down.
class TurningTexture {
 public:
  TurningTexture(int half, double radius, double blur, bool turned_round);

  /// From the windows in their present states: what part and ground as they stand leave unexplained.
  void learn(WindowSpan windows, const PartPictures& part, const GroundPicture& ground);

  /// T(R(-theta) u) on the part's grid. `slope`, if wanted, receives its derivative by theta.
  Picture at(double theta, Picture* slope = nullptr) const;
  /// Grey levels rms over the face.
  double contrast() const;

 private:
  struct Places {
    std::vector<std::size_t> pixel;
    std::vector<float> x, y;
  };
  Places face_turned(double theta) const;

  void take_out_rings();

  int half_;
  bool turned_round_;
  std::vector<float> face_;  ///< 1 where there is a texture, 0 where it has ended
  Picture levels_;
  QuinticSpline spline_;
};

}  // namespace tribotrack::vision
