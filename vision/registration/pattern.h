// The template: a window of the first analysed frame, and which of its pixels count.
#pragma once

#include "vision/picture.h"
#include "vision/registration/template_match.h"

namespace tribotrack::vision {

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
  double reach() const;  ///< radius, or half the shorter side
};

/// Round mask about the circle, `margin` px beyond the disc's radius, for the rim carries nearly all
/// information; clipped to the picture.
Pattern disc_pattern(const Picture& first, const Circle& disc, double margin = 3);

/// Everything in the rectangle counts; its centre is tracked.
Pattern rectangle_pattern(const Rect& rectangle);

/// Template for a coarse search. For a disc: its radial profile, so that a turned disc matches as well.
MaskedTemplate search_template(const Picture& first, const Pattern& pattern);

// Does the part's texture show its rotation, and how well?

/// Cramer-Rao bound of the rotation alone from one frame, rad: sqrt(noise_variance / sum (dT/dtheta)^2) over
/// the pixels inside the rim; 1e9 where no texture stands out of the noise. `levels` is the pattern's window.
///
/// Noise has slopes of its own, which grow with every pixel while a few scratches do not: slopes are taken
/// of the picture smoothed to a scratch's width. What is much wider than that, a lamp's reflection or
/// shading, holds no information on rotation and is taken out. The bound is that of what is left, so the true
/// one is less.
double rotation_limit(const Picture& levels, const Pattern& pattern, double noise_variance);

}  // namespace tribotrack::vision
