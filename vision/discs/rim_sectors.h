// The rim measured sector by sector: where a round part is, whatever turns inside it.
//
// In each sector k of the rim the levels on both sides are its own, and so is the place of the edge,
//   I(rho) = O_k + (A_k - O_k) Phi((R + d_k - rho) / s),
// with Phi and s as in disc_detection.h; linear in O_k, A_k - O_k and, to the first order, in d_k. A circle
// is fitted to the edges, each weighted by how well its pixels show it. Nothing but round edges counts: no
// picture of the part is compared, a highlight or a streak that passes along the rim changes levels, not
// edges. What it costs against a template of a part that does not change is a factor of 1.5 to 2.
//
// What makes a rim look not round - a chamfer's glint, a shadow, a scratch - is in the covariance.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "vision/picture.h"

namespace tribotrack::vision {

/// What is known of the rim before a frame is measured.
struct RimShape {
  double radius = 0, blur = 0;  ///< px
  double unevenness = 0;        ///< RimSectors::unevenness of the frame that shape was taken from, px
  Point offset;                 ///< from the circle through its edges to the part's centre there, px
};

struct RimSectors {
  Circle circle;
  /// Of its centre, px^2: N^-1 (sum i^2 d^2 u u^T) N^-1, i and d the sectors' information and what is left of
  /// their edges' displacements, u their directions. It holds whatever makes the rim uneven, as long as
  /// sectors err independently, and is never less than what noise does.
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
  double coverage = 0;      ///< share of the sectors that show the edge
  double unevenness = 0;    ///< usual size of the deviations, px
  double correlation = 0;   ///< of the pixels near the rim with the edges fitted to them, -1 .. 1
  double residual_rms = 0;  ///< what the edges leave of them, grey levels
};

/// The rim about `start`, whose centre is known to about twice the blur. nullopt where less than half of it
/// is seen, or the circle walks away from the start.
std::optional<RimSectors> measure_rim_sectors(const Picture& picture, const Circle& start, double blur);

/// Whether that is the rim of the same part: its radius, about as round as it was, and an edge of either sign
/// over most of the way round. Levels do not count: metal that turns under a lamp brightens and darkens.
bool same_rim(const RimSectors& seen, const RimShape& known);

/// Of what was seen in a frame in which the part is known to be there, at `centre`.
RimShape shape_of(const RimSectors& seen, double blur, const Point& centre);

}  // namespace tribotrack::vision
