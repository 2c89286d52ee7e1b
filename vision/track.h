// A track: where the part was in every frame, and how well that is known.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "vision/picture.h"

namespace tribotrack::vision {

enum class TrackStatus {
  ok,    ///< measured in this frame
  lost,  ///< not found; no position
  edge,  ///< reaches out of the picture; no position
};

const char* to_string(TrackStatus status);

/// The marker in one frame (fixed to the platform).
struct MarkerPoint {
  double x = 0, y = 0;  ///< px
  double sigma = 0;     ///< px, per axis
  double ncc = 0;
};

/// One frame. Positions are meaningful only for status ok.
struct TrackPoint {
  std::int64_t frame = 0;                       ///< the recording's own number
  double time_s = 0;                            ///< 0 at the recording's first stored image
  double x = 0, y = 0;                          ///< the part's centre, px
  double sigma_x = 0, sigma_y = 0, rho_xy = 0;  ///< standard deviations, px, and correlation
  double ncc = 0;                               ///< normalised cross-correlation with the template, -1 .. 1
  TrackStatus status = TrackStatus::lost;
  std::optional<MarkerPoint> marker;  ///< where a marker is followed and was found
  std::optional<double> gate;         ///< the lamp's mean grey level, where one is named
};

/// Millimetres per pixel and where they come from.
struct Scale {
  double mm_per_px = 0;
  double sd = 0;       ///< mm/px
  std::string source;  ///< "given", "part's diameter"
};

struct Track {
  std::vector<TrackPoint> points;  ///< one per analysed frame, in order
  bool has_marker = false;
  bool has_gate = false;
  /// Frame of the first point that is ok; of the first of all where none is. Not for an empty track.
  std::int64_t first_seen() const;
};

}  // namespace tribotrack::vision
