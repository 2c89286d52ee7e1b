// How a coder stored the rim of a disc in one frame.
//
// A displacement along x is told by the edges across it, so a place of the rim at the angle phi counts by
// cos^2 phi for x and by sin^2 phi for y.
#pragma once

#include "vision/frame_source.h"
#include "vision/picture.h"

namespace tribotrack::vision {

struct RimCoding {
  char type = '?';        ///< of the frame
  double step = 0;        ///< of the quantiser at the rim, grey levels; 0 unknown
  Point still = {0, 0};   ///< share that is predicted from the same place of another frame, for x and y
  Point moving = {0, 0};  ///< share that is predicted from elsewhere
};

RimCoding rim_coding(const CodedFrame& frame, const Circle& rim);

}  // namespace tribotrack::vision
