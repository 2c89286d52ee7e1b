// The windows the layers are learnt from, and the platform's picture from the same frames.
#pragma once

#include <vector>

#include "vision/frame_source.h"
#include "vision/layers/model/ground.h"
#include "vision/layers/model/state.h"
#include "vision/stages/first_pass_result.h"

namespace tribotrack::vision {

/// Places of the platform, in its frame, that are seen about the part's path.
Rect swath(const std::vector<FirstPassFrame>& frames, double reach, const Rect& bounds);

/// Frames spread over the recording, as many as memory has room for.
class LearningFrames {
 public:
  /// Keeps references. `reach` px about the part's centre, `hidden` the radius within which there is no
  /// ground.
  LearningFrames(FrameSource& source, const std::vector<FirstPassFrame>& frames, const FirstPassResult& first,
                 double reach, double hidden);

  const Rect& region() const { return region_; }
  std::size_t count() const { return chosen_.size(); }

  /// Their windows, in the order of time; and the ground, averaged from frames spread over the recording.
  std::vector<KeptWindow> read(GroundPicture& ground);
  /// The ground alone, again, seen from so near to the part.
  void read_ground(GroundPicture& ground, double hidden);

 private:
  void read_ground(GroundPicture& ground);
  Circle part_in(const FirstPassFrame& f) const { return {f.centre.x, f.centre.y, hidden_}; }

  FrameSource& source_;
  const std::vector<FirstPassFrame>& frames_;
  const FirstPassResult& first_;
  double reach_, hidden_;
  Rect region_, read_;                               ///< the latter of every frame
  std::vector<std::size_t> chosen_, ground_frames_;  ///< of frames_
};

}  // namespace tribotrack::vision
