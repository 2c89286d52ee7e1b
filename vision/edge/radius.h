// A disc's radius: that of the edge which the camera sees, and how far its outer edge lies beyond.
//
// Seen from above a chamfer is a ring about the part's top. As dark as the ground it hides the outer edge,
// and a circle fitted to the edge has the top's radius; as bright as the top it hides the top's. With w its
// width
//   R = R_seen + c,   0 <= c <= w.
// A ring wider than some three blurs shows in the mean picture's rays, whatever its levels (rays.h): then
// c is measured, about a centre of its own: a lamp at the side lights one half of a chamfer, so that the edge
// which is seen is the outer one on one side and the top's on the other. A narrower one cannot be told from
// the ground: then the prior is all there is.
//   w known:      mean w/2, sd w/sqrt(8). The level of the ring may be any from that of the ground to that of
//                 the top; the edge is then seen at one end of a ring of three blurs more often than between
//                 (anywhere alike would be w/sqrt(12), as of a ring below one blur).
//   w not known:  up to the widest that would not show, the wider the less likely (a density that falls
//                 linearly): mean w/3, sd w/sqrt(18).
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "vision/discs/disc_detection.h"
#include "vision/frame_source.h"
#include "vision/picture.h"
#include "vision/stages/stages.h"

namespace tribotrack::vision {

struct OuterEdge {
  double beyond = 0, beyond_sd = 0;  ///< c, px
  double widest = 0;                 ///< px: w where known or measured, else what would not show
  bool measured = false;             ///< c is seen
  Point off = {};                    ///< of its centre from that of the edge that is seen, px
};

/// The edge that is seen, in the mean of some of the frames about the part's centres: noise averages out,
/// what belongs to the disc and to the ground that stays beside it does not. Nothing where no whole edge
/// shows.
///
/// Colour video is not linear in the light: it stores about its power 1 / 2.2, so the middle of a blurred
/// edge, as stored, lies outside its true place on a bright disc (inside on a dark one), by
///   kappa s,  kappa = -Phi^-1((h^2.2 - o^2.2) / (a^2.2 - o^2.2)),  h = (a + o) / 2,
/// for stored levels a inside and o outside and the blur s. Whether a camera does this is not known: kappa
/// counts half, with the spread of what lies between none and all of it.
std::optional<DiscFit> seen_edge(FrameSource& source, const SeenFrames& frames, double radius);

/// `chamfer`: w over the radius, if it is known. `frames` with the part's centres to a fraction of the blur;
/// those of them are read, if any, that it takes to see a wide chamfer. `radius` is R_seen and `blur` that of
/// its edge, px.
OuterEdge outer_edge(FrameSource& source, const SeenFrames& frames, double radius, double blur,
                     double noise_variance, std::optional<double> chamfer);

// Is a disc seen as one? Pixels that are not square and a camera that looks from the side make it an ellipse.

/// A sentence where the steepest edges around the disc lie at radii that go with cos 2 theta by more than 3 %
/// (axes that differ by 6 %) and half a pixel, beyond their scatter; nothing where they do not, or lie too
/// near to the picture's rim.
std::optional<std::string> roundness_warning(const Picture& picture, const Circle& disc);

}  // namespace tribotrack::vision
