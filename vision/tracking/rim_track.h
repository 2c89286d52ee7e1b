// The part's track by its rim alone, beside that by its template: which of the two is better, by evidence.
//
// The template is the sharper instrument where the part looks the same in all frames, the rim where it does
// not (metal that turns under a lamp, a coder's smear). Both are tried on a sample of frames. The rim's
// variance is that of its sectors among each other (rim_sectors.h). The template's is what it claims, or,
// where the two disagree by more than both claim, what the disagreement leaves for it.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "vision/discs/rim_sectors.h"
#include "vision/following/pattern_follower.h"
#include "vision/frame_source.h"
#include "vision/stages/first_pass_result.h"
#include "vision/track.h"

namespace tribotrack::vision {

/// What was found, for the plan.
struct RimEvidence {
  std::int64_t frames = 0;    ///< in which the part was found
  std::int64_t rim_only = 0;  ///< of them: the template was not confirmed, or not tried
  std::int64_t compared = 0;  ///< in which both were measured
  double rim_px = 0;          ///< predicted error of a coordinate
  double template_px = 0;     ///< the same
  bool chosen = false;        ///< every frame is measured by the rim
};

class RimTrack {
 public:
  /// Without a shape it does nothing. Of the frames shown a sample is measured, see in_sample().
  RimTrack(std::optional<RimShape> shape, std::int64_t stride) : shape_(shape), stride_(stride) {}

  /// A frame in which the part was found: point number `place` of the track.
  void see(FrameSource& source, std::int64_t index, std::size_t place, const Sighting& sighting);

  /// After the last frame: positions, covariances and correlations of the points that the rim measures
  /// better, or alone. Reads frames again where it is chosen for all.
  RimEvidence settle(FrameSource& source, FirstPassResult& result, Track& track);

 private:
  struct Row {
    std::size_t place = 0;
    bool by_template = false;  ///< too
    RimSectors rim;
  };
  std::optional<RimSectors> measure(FrameSource& source, std::int64_t index, const Point& centre) const;
  static std::vector<float> pattern_of(const std::vector<Row>& rows);
  void measure_all(FrameSource& source, std::int64_t first_index, const Track& track);

  std::optional<RimShape> shape_;
  std::int64_t stride_, seen_ = 0;
  std::vector<Row> rows_;
};

}  // namespace tribotrack::vision
