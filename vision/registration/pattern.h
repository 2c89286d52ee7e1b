// Normalised cross-correlation of a masked template with a picture, at whole pixels.
//
// zncc = sum w (T - <T>) (I - <I>) / sqrt(sum w (T - <T>)^2 sum w (I - <I>)^2), <.> the mean under the mask
// w: blind to gain and offset of the light. (OpenCV's masked TM_CCOEFF_NORMED returns inf on flat ground,
// hence our own.)
#pragma once

#include <vector>

#include "vision/picture.h"

namespace tribotrack::vision {

/// A template and its mask, both of one size. Only where weights > 0 do levels count.
struct MaskedTemplate {
  Picture levels;
  Picture weights;
};

/// Position of the template's first pixel in the picture, and the score there.
struct Match {
  int x = 0, y = 0;
  double ncc = -1;
};

class TemplateMatcher {
 public:
  explicit TemplateMatcher(const MaskedTemplate& pattern);

  /// Score with the template's first pixel at (x, y), which must leave the template inside the picture. 0 on
  /// flat ground.
  double score(const Picture& picture, int x, int y) const;

  /// Local maxima of the score over the whole picture, best first, at least `separation` px apart and scoring
  /// at least min_ncc: found on a picture reduced by averaging, then followed uphill at full size.
  std::vector<Match> search(const Picture& picture, double min_ncc, double separation, int max_count) const;

 private:
  Match climb(const Picture& picture, Match from, int step) const;

  int width_ = 0, height_ = 0;
  Picture shape_;    ///< w (T - <T>) / sqrt(sum w (T - <T>)^2)
  Picture weights_;  ///< w
  double weight_ = 0;
  double pivot_ = 0;  ///< subtracted from the picture's levels so that sums of squares keep their digits
  MaskedTemplate reduced_;  ///< averaged over reduction_ x reduction_ pixels
  int reduction_ = 1;
};

// The template: a window of the first analysed frame, and which of its pixels count.

struct Pattern {
  Rect window;        ///< place in the first frame
  Picture weights;    ///< 1 where a pixel counts, 0 elsewhere; size of the window
  Point centre;       ///< what is tracked, px of the first frame
  double radius = 0;  ///< of the disc; 0 for a rectangle
  /// Whether the shape at `centre` (disc with `margin` px around it, or the rectangle) lies inside bounds.
  bool inside(const Rect& bounds, const Point& at, double margin) const;
  /// Whether any of it does.
  bool overlaps(const Rect& bounds, const Point& at) const;
  Point half() const {  ///< of the shape's extent, px
    return radius > 0 ? Point{radius, radius} : Point{0.5 * window.width, 0.5 * window.height};
  }
  double reach() const { return std::min(half().x, half().y); }  ///< radius, or half the shorter side
};

/// Round mask about the circle, `margin` px beyond the disc's radius, for the rim carries nearly all
/// information; clipped to the picture.
Pattern disc_pattern(const Picture& first, const Circle& disc, double margin = 3);

/// Everything in the rectangle counts; its centre is tracked.
Pattern rectangle_pattern(const Rect& rectangle);

/// Template for a coarse search. For a disc: its radial profile, so that a turned disc matches as well.
MaskedTemplate search_template(const Picture& first, const Pattern& pattern);

}  // namespace tribotrack::vision
