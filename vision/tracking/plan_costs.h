// What each stage of the plan costs, predicted from the scene: shares of the run time.
//
// Costs are in pixels that the part's plain registration visits per frame. What a stage does to a pixel is
// weighed by what it takes beside that registration: rough estimates, good to a factor of two.
#pragma once

#include <cstdint>
#include <vector>

#include "vision/picture.h"

namespace tribotrack::vision {

struct PlanStage;

struct PlanCosts {
  double part_pixels = 0;    ///< that take part in the plain registration
  double mask_pixels = 0;    ///< of the whole template
  double window_pixels = 0;  ///< read per frame
  double frames = 1;

  /// Reading and registration, without which there is no track.
  double base() const { return part_pixels + 0.1 * window_pixels; }
  double rotation() const { return 15 * mask_pixels; }
  double averaging(double averaged_frames) const { return 3 * averaged_frames * base() / frames; }
  double marker(double radius) const { return 3.2 * (2 * radius + 7) * (2 * radius + 7); }
  /// A correlation at every whole position within `margin` px.
  double window_search(double margin) const {
    return 0.05 * (2 * margin + 1) * (2 * margin + 1) * mask_pixels / 10;
  }
  /// On a reduced picture first.
  double whole_search(const Rect& picture) const { return 6.0 * picture.width * picture.height; }
  /// The second pass, and learning from `windows` of the frames.
  double layers(double radius, double windows) const;
};

/// Fills predicted_saving of every stage from its cost: for one that is on, the share of the run time that
/// leaving it out would save; for one that is off, the share that was saved.
void predict_savings(std::vector<PlanStage>& plan, double base);

}  // namespace tribotrack::vision
