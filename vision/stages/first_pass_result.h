// What the first pass leaves to the second, beside the track.
#pragma once

#include <cstdint>
#include <vector>

#include "vision/audit/halves.h"
#include "vision/picture.h"

namespace tribotrack::vision {

struct FirstPassResult {
  std::int64_t first_index = 0;     ///< of the track's first point in the source
  std::int64_t total = 0;           ///< frames analysed
  Circle disc;                      ///< in the first frame
  double blur = 0;                  ///< of its rim, px; 0 where the part is not a disc
  double contrast = 0;              ///< across it, grey levels; 0 where the part is not a disc
  double limit_px = 0;              ///< Cramer-Rao bound of a coordinate by the template
  bool turning = false;             ///< the part's texture shows its rotation
  bool texture_seen = false;        ///< in the first frame there is a texture that would show it
  std::vector<double> theta;        ///< that rotation, rad, one per point; 0 where not ok
  std::vector<double> sigma_theta;  ///< its standard deviation; 0 where it was not measured
  std::vector<bool> by_rim;         ///< the template was not confirmed: by the rim alone, theta as predicted
  std::vector<AuditFrame> audited;  ///< frames whose halves were compared, none measured by the rim
  std::vector<double> residual;     ///< grey levels rms, one per point; 0 where not ok
  double noise_variance = 0;
  double ground_texture = 0;  ///< about the part in the first frame, grey levels rms beyond the noise
  double excess = 0;          ///< median residual beyond the noise, grey levels rms
};

}  // namespace tribotrack::vision
