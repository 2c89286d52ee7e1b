// A track in millimetres: the part's top and the marker's plane each with its own scale, or through a
// calibrated camera. Positions are mapped, pictures never resampled.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "vision/camera_calibration.h"
#include "vision/track.h"
#include "vision/tracker.h"

namespace tribotrack::vision {

/// The part's top lies height_mm above the marker's plane (the platform), which lies distance_mm from the
/// lens's pupil: at the same magnification the top is nearer and looks larger, mm/px there are 1 -
/// height/distance of those below.
struct Parallax {
  double height_mm = 0;
  double distance_mm = 0;
};

/// The plane for which a scale holds: the part's diameter is seen at its top, a ruler lies on the platform.
enum class ScalePlane { part_top, platform };

/// What pixels mean in millimetres, in both planes.
class PlaneGeometry {
 public:
  /// One scale, and where parallax is given the other plane's from it. Throws std::invalid_argument unless 0
  /// <= height < distance.
  PlaneGeometry(const Scale& scale, ScalePlane plane, const std::optional<Parallax>& parallax);
  /// A calibrated camera; the part's top lies height_mm above the calibrated plane.
  PlaneGeometry(const CameraCalibration& calibration, double height_mm);

  PlanePoint part(Point pixel) const;
  PlanePoint marker(Point pixel) const;
  const Scale& part_scale() const { return part_; }  ///< of a calibrated camera: in the picture's middle
  const Scale& marker_scale() const { return marker_; }
  bool calibrated() const { return calibration_.has_value(); }
  /// Both planes alike and no lens: a factor is all there is.
  bool plain() const { return !calibration_ && part_.mm_per_px == marker_.mm_per_px; }

  /// What is left when stages are left out whose corrections do not show in this track: parallax, lens. Each
  /// says so in the plan, with the largest correction it would make against a tenth of the tracking's sd.
  PlaneGeometry as_needed(const Track& track, double tracking_sd_px, std::vector<PlanStage>& plan) const;

 private:
  Scale part_, marker_;
  ScalePlane known_ = ScalePlane::platform;  ///< the other's scale follows from this one's
  std::optional<CameraCalibration> calibration_;
  double height_mm_ = 0;
};

/// A tracked point in campaign axes (x right, y up, turned by -xi_axis_rad).
struct PlacedPoint {
  Eigen::Vector2d mm =
      Eigen::Vector2d::Zero();  ///< relative to the first, in the platform's frame where known
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  ///< mm^2, of this point's own noise
  std::optional<Eigen::Vector2d> marker_mm;              ///< in the plane, not relative
  double marker_sigma_mm = 0;
};

/// One per point; nullopt where not ok (or the marker was not found in that frame).
///   part relative to platform = [P(x_k) - P(x_0)] - [M(m_k) - M(m_0)],
/// P, M the maps of both planes; covariances by their slopes.
std::vector<std::optional<PlacedPoint>> place_track(const Track& track, const PlaneGeometry& geometry,
                                                    double xi_axis_rad);

}  // namespace tribotrack::vision
