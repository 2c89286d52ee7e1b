// Tracks in millimetres: the scale of a picture, the part's top and the marker's plane each with its own, or
// through a calibrated camera. Positions are mapped, pictures never resampled.
//
// With one scale per plane a pixel (u, v) maps to mm_per_px (u, -v): y points up. A part of height h on a
// platform at distance L from the lens's pupil is nearer by h, so mm_per_px at its top is (1 - h / L) of that
// at the platform; the part's displacement relative to the platform needs both.
//
//   const Scale scale = scale_from_diameter(20.0, summary.outer_radius, summary.outer_radius_sd, 0.01);
//   const PlaneGeometry geometry(scale, ScalePlane::part_top, Parallax{3.2, 450});
//   for (const auto& point : place_track(track, geometry, 0))
//     if (point) std::cout << point->mm.transpose() << " mm, sd " << std::sqrt(point->covariance(0, 0)) <<
//     "\n";
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "vision/calibration.h"
#include "vision/track.h"
#include "vision/tracker.h"

namespace tribotrack::vision {

/// From the part's true diameter D and the radius R of its outer edge in the picture (edge/chamfer.h), that
/// of the sharp disc before the blur of optics and pixels:
///   mm_per_px = D / (2 R),   (sd / mm_per_px)^2 = (sd(D) / D)^2 + (sd(R) / R)^2.
Scale scale_from_diameter(double diameter_mm, double radius_px, double radius_sd_px,
                          double diameter_sd_mm = 0);

/// From the side of a square tag on the platform, in the same way.
Scale scale_from_tag(double side_mm, const SeenTag& tag, double side_sd_mm = 0);

/// As the user gave it, with the sd the user gave.
Scale given_scale(double mm_per_px, double sd = 0);

/// Several recordings of one part by one camera that did not move.
struct PooledScale {
  Scale scale;            ///< sd: that of the mean, and what all recordings share
  double chi2 = 0;        ///< of the recordings' own scales about their mean, count - 1 degrees of freedom
  int count = 0;          ///< recordings
  double scatter = 0;     ///< between recordings, beyond their own sds; 0 where these explain chi2
  bool one_scale = true;  ///< no scatter, or one that rims on differing backgrounds explain (kRimScatter)
};

/// Scatter between recordings, of the scale, up to which it is that of measuring: the background of a rim
/// pulls its radius by some hundredths of a pixel. A camera that is moved changes its scale by more.
inline constexpr double kRimScatter = 5e-4;

/// The mean weighted by 1 / (sd^2 + scatter^2), sd without what they share: relative sd `common_relative_sd`
/// (the part's true diameter), which each of `scales` holds in its sd and which no averaging takes out. Where
/// chance gives such a chi2 in fewer than 1 of 1000 campaigns the scatter is estimated by moments
/// (DerSimonian, Laird 1986). Scales without an sd must be equal. Throws std::invalid_argument for an empty
/// list.
PooledScale pooled_scale(std::span<const Scale> scales, double common_relative_sd = 0);

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

 private:
  Scale part_, marker_;
  std::optional<CameraCalibration> calibration_;
  double height_mm_ = 0;
};

/// A tracked point in campaign axes (x right, y up, turned by -xi_axis_rad).
struct PlacedPoint {
  /// Relative to the first, in the platform's frame where known.
  Eigen::Vector2d mm = Eigen::Vector2d::Zero();
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
