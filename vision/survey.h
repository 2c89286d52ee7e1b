// What a recording shows before anything is given: discs and how they move, lamps that switch.
//
//   const auto source = open_source("run.cine");
//   const Survey seen = survey(*source);
//   if (const SurveyedDisc* part = seen.part()) std::cout << part->circle.x << ' ' << part->circle.y << '\n';
//
// It looks at some frames and measures nothing: positions are good to a fraction of a pixel, roles are
// guesses for the user to confirm (write_survey_png in overlay.h draws them).
#pragma once

#include <cstdint>
#include <vector>

#include "vision/frame_source.h"

namespace tribotrack::vision {

/// What a disc may be, by how it moves in the frames looked at.
enum class DiscRole {
  part,       ///< moves farthest; if nothing moves, the one seen best
  like_part,  ///< as large as the part, and moves too
  mark,       ///< moves about its place, like something fixed to the platform
  resting     ///< stays where it is: fixed to the camera's frame, or to a platform at rest
};

struct SurveyedDisc {
  Circle circle;        ///< in the survey's frame
  double coverage = 0;  ///< share of its edge that is seen, 0 .. 1
  double moved_px = 0;  ///< the farthest it was seen from there in other frames
  int seen_in = 0;      ///< of Survey::frames_looked_at
  DiscRole role = DiscRole::resting;
};

/// A place that switches between two levels again and again.
struct SurveyedLamp {
  Circle circle;
  double dark = 0, lit = 0;  ///< grey levels, means over the circle
  double lit_share = 0;      ///< of the frames
};

struct Survey {
  std::int64_t frame = 0;           ///< of the circles, the recording's own number: the first with a disc
  int frames_looked_at = 0;         ///< for discs
  std::vector<SurveyedDisc> discs;  ///< the part first, then marks, then the rest; each best first
  std::vector<SurveyedLamp> lamps;  ///< brightest change first

  /// Null where no disc was found.
  const SurveyedDisc* part() const { return discs.empty() ? nullptr : &discs.front(); }
  /// The mark seen best; null where there is none.
  const SurveyedDisc* mark() const;
  /// Whether anything but the part moves with a platform: a mark does.
  bool platform_moves() const { return mark() != nullptr; }
};

/// Of the first `span` frames at most `most`, in rising order. Their distances do not repeat (multiples of
/// the golden section), so that no lamp's frequency is missed for being in step with them.
std::vector<std::int64_t> spread_frames(std::int64_t span, int most);

/// Throws InputError where frames cannot be read.
Survey survey(FrameSource& source);

}  // namespace tribotrack::vision
