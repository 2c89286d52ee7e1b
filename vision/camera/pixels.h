// The camera's pixels: their noise, and those that are hot, dead or stuck.
#pragma once

#include <vector>

#include "vision/frame_source.h"
#include "vision/picture.h"

namespace tribotrack::vision {

// How noisy is a recording?

/// Variance of one pixel, grey levels^2, from pairs of consecutive frames: half the variance of their
/// difference over 8 x 8 px blocks, the mean over the blocks that noise alone explains (parts that move are a
/// minority), the mean over pairs. Blocks rather than pixels, so that a change of light cancels; clipped and
/// black blocks are left out. Of large pictures some rows of blocks, other ones in every pair. Never below
/// the 1/12 of rounding to whole levels. One picture alone: from second differences, which a texture of a few
/// pixels raises.
class NoiseEstimate {
 public:
  void add_pair(const Picture& a, const Picture& b);
  double variance(const Picture& first) const;

 private:
  double sum_ = 0;
  int pairs_ = 0;
};

/// From one picture (Immerkaer, "Fast noise variance estimation", CVIU 64, 1996), median over blocks.
double noise_variance(const Picture& picture);

// Hot, dead and stuck pixels of the camera.

struct Pixel {
  int x = 0, y = 0;
};

/// Finds pixels that stand out of all their neighbours, or of all but one of them, in every picture and to
/// the same side: by 8 sd of the noise and by twice what the neighbours differ among themselves. Optics blur
/// every point of the scene over more than a pixel (Gaussian sd >= 0.5 px: a point lights its neighbours by a
/// third of its own level), so no part of the scene does that.
class BadPixelSearch {
 public:
  /// `noise_variance` in grey levels^2.
  BadPixelSearch(const Picture& picture, double noise_variance);
  /// Examines another picture of the recording.
  void look(const Picture& picture);
  /// Nothing stands out, or no longer: no further pictures are needed.
  bool settled() const { return found_.empty(); }
  /// Empty before a second picture.
  std::vector<Pixel> found() const { return others_ > 0 ? found_ : std::vector<Pixel>(); }

 private:
  float least_;
  std::vector<Pixel> found_;
  std::vector<int> sides_;  ///< +1 bright, -1 dark
  int others_ = 0;
};

/// A recording whose bad pixels show the median of their good neighbours.
class MendedSource : public FrameSource {
 public:
  /// `source` must outlive this.
  MendedSource(FrameSource& source, std::vector<Pixel> bad);
  void fill(std::int64_t index, const Rect& window, Picture& picture) override;

 private:
  FrameSource& source_;
  std::vector<Pixel> bad_;                   ///< by rows
  std::vector<std::vector<Pixel>> healthy_;  ///< neighbours of each
};

}  // namespace tribotrack::vision
