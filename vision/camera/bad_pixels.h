// Pixels of the camera that do not tell what they see: hot, dead or stuck.
#pragma once

#include <span>
#include <vector>

#include "vision/frame_source.h"

namespace tribotrack::vision {

struct Pixel {
  int x = 0, y = 0;
};

/// Pixels that stand out of all their neighbours, or of all but one of them, in every picture and to the same
/// side: by 8 sd of the noise and by twice what the neighbours differ among themselves. Optics blur whatever
/// lies before the lens over more than a pixel (Gaussian sd >= 0.5 px: a point lights its neighbours by a
/// third of what it is itself), so no part of the scene does that.
/// At least two pictures of one recording; `noise_variance` in grey levels^2.
std::vector<Pixel> find_bad_pixels(std::span<const Picture> pictures, double noise_variance);

/// The same, picture by picture.
class BadPixelSearch {
 public:
  BadPixelSearch(const Picture& picture, double noise_variance);
  /// At another picture of the recording.
  void look(const Picture& picture);
  /// Nothing stands out, or no longer: further pictures need not be looked at.
  bool settled() const { return found_.empty(); }
  /// None before a second picture.
  std::vector<Pixel> found() const;

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
  using FrameSource::read;
  void read(std::int64_t index, const Rect& window, Picture& picture) override;

 private:
  FrameSource& source_;
  std::vector<Pixel> bad_;                   ///< by rows
  std::vector<std::vector<Pixel>> healthy_;  ///< neighbours of each
};

}  // namespace tribotrack::vision
