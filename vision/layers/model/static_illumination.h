// Light that stands in the picture: a reflection in the window, a lamp's glare, shading, vignetting.
//
// The camera sees  I(x) = L(x) scene(x, t) + H(x)  with L and H fixed in the picture, and where something
// opaque stands it sees nothing of the scene.
#pragma once

#include "vision/picture.h"

namespace tribotrack::vision {

class StaticIllumination {
 public:
  /// A level no picture has: stands for pixels that show nothing of the scene.
  static constexpr float kUnseen = -1e9F;
  static bool unseen(float level) { return level < 0.5F * kUnseen; }

  /// Nothing stands in the picture.
  StaticIllumination() = default;
  /// L = 1, H = 0 over a region. Pixels at `top` are clipped: where light is added they do not tell the
  /// scene.
  StaticIllumination(const Rect& region, double top);

  bool empty() const { return gain_.empty(); }
  double top() const { return top_; }
  const Rect& region() const { return region_; }
  Picture& gain() { return gain_; }      ///< L over the region
  Picture& offset() { return offset_; }  ///< H
  Picture& hidden() { return hidden_; }  ///< 1 where something opaque stands, else 0
  const Picture& gain() const { return gain_; }
  const Picture& offset() const { return offset_; }
  const Picture& hidden() const { return hidden_; }

  /// Turns a window of a frame, its first pixel at pixel (x, y), into what the scene shows, (I - H) / L;
  /// unseen pixels keep what this makes of them unless they are to be marked.
  void take_out(Picture& picture, int x, int y, bool mark_unseen) const;
  /// The other way round, for pictures without marks.
  void put_in(Picture& picture, int x, int y) const;

 private:
  template <class Act>
  void each(Picture& picture, int x, int y, const Act& act) const;
  Rect region_;
  float top_ = 255;
  Picture gain_, offset_, hidden_;
};

}  // namespace tribotrack::vision
