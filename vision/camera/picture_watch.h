// Sources between a recording and its tracker: one that looks at the pictures as they pass, for what they
// themselves tell of time, and one that hands out some of the frames only.
#pragma once

#include <array>
#include <functional>
#include <vector>

#include "vision/duplicate_frames.h"
#include "vision/frame_source.h"
#include "vision/track.h"
#include "vision/tracker.h"

namespace tribotrack::vision {

/// Hands on what it reads, and compares each frame read after the one before it: see RepeatedFrames. Other
/// reads are not looked at. What is not decoded costs one row a frame, what is some per cent of decoding.
class PictureWatch : public FrameSource {
 public:
  explicit PictureWatch(FrameSource& source) : source_(source) { info_ = source.info(); }
  using FrameSource::read;
  void read(std::int64_t index, const Rect& window, Picture& picture) override;
  const CodedFrame* coded(std::int64_t index) const override { return source_.coded(index); }
  RepeatedFrames found() const;

 private:
  void look_at_decoded(std::int64_t index);
  void look_at_rows(std::int64_t index);
  Picture& kept(std::int64_t index) { return kept_[static_cast<std::size_t>(index) % kept_.size()]; }

  FrameSource& source_;
  std::int64_t first_ = -1, next_ = -1;  ///< indices of the first frame looked at, and of the next one
  std::array<Picture, 4> kept_;
  std::int64_t whole_index_ = -1;  ///< not decoded: of the whole picture in whole_
  Picture whole_;
  /// Of frame first_ + k: by how much it differs from the one before, and the one before from the one after
  /// next: that is, two steps on. Grey levels, see step_of.
  std::vector<float> step_, over_;
  std::vector<double> weave_;  ///< of each frame, projection of rows' differences on motion
  double weave_square_ = 0;
};

/// Frames of a source by their indices, rising; numbers and times are theirs.
class SelectedFrames : public FrameSource {
 public:
  SelectedFrames(FrameSource& source, std::vector<std::int64_t> indices);
  using FrameSource::read;
  void read(std::int64_t index, const Rect& window, Picture& picture) override {
    source_.read(indices_[static_cast<std::size_t>(index)], window, picture);
  }
  const CodedFrame* coded(std::int64_t index) const override {
    return source_.coded(indices_[static_cast<std::size_t>(index)]);
  }

 private:
  FrameSource& source_;
  std::vector<std::int64_t> indices_;
};

/// Tracks every n-th frame, as the options say, by `run`; again without the pictures that repeat others, if
/// the first run meets such: these become points of status `repeat`. Throws InputError for weaved fields.
TrackResult track_each_picture_once(
    FrameSource& recording, const TrackOptions& options,
    const std::function<TrackResult(FrameSource& source, const TrackOptions& options)>& run);

}  // namespace tribotrack::vision
