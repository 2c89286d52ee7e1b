#include <Eigen/Geometry>
#include <Eigen/QR>
#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <cmath>
#include <stdexcept>

#include "vision/kernels/dense.h"
#include "vision/millimetres.h"

namespace tribotrack::vision {
namespace {

/// Chi-squared exceeded once in 1000.
double chi2_of_one_in_thousand(int degrees) {
  return quantile(complement(boost::math::chi_squared(degrees), 1e-3));
}

}  // namespace

Scale scale_from_diameter(double diameter_mm, double radius_px, double radius_sd_px, double diameter_sd_mm) {
  if (!(diameter_mm > 0) || !(radius_px > 0))
    throw std::invalid_argument("the part's diameter must be greater than 0");
  const double mm_per_px = diameter_mm / (2 * radius_px);
  return {mm_per_px, mm_per_px * std::hypot(radius_sd_px / radius_px, diameter_sd_mm / diameter_mm),
          "part's diameter"};
}

Scale scale_from_tag(double side_mm, const SeenTag& tag, double side_sd_mm) {
  if (!(side_mm > 0) || !(tag.side_px > 0))
    throw std::invalid_argument("the tag's side must be greater than 0");
  const double mm_per_px = side_mm / tag.side_px;
  return {mm_per_px, mm_per_px * std::hypot(tag.side_sd_px / tag.side_px, side_sd_mm / side_mm), "tag"};
}

Scale given_scale(double mm_per_px, double sd) {
  if (!(mm_per_px > 0)) throw std::invalid_argument("mm_per_px must be greater than 0");
  if (!(sd >= 0)) throw std::invalid_argument("mm_per_px_sd must not be negative");
  return {mm_per_px, sd, "given"};
}

PooledScale pooled_scale(std::span<const Scale> scales, double common_relative_sd) {
  if (scales.empty()) throw std::invalid_argument("no scale to take the mean of");
  PooledScale pooled;
  pooled.count = static_cast<int>(scales.size());
  pooled.scale = scales.front();
  const auto own_variance = [&](const Scale& s) {
    const double common = common_relative_sd * s.mm_per_px;
    return std::max(0.0, s.sd * s.sd - common * common);
  };
  const bool exact =
      std::any_of(scales.begin(), scales.end(), [&](const Scale& s) { return own_variance(s) <= 0; });
  if (exact) {
    for (const Scale& s : scales)
      pooled.one_scale =
          pooled.one_scale && s.mm_per_px == scales.front().mm_per_px && s.sd == scales.front().sd;
    return pooled;
  }
  struct Sums {
    double weight = 0, square = 0, value = 0, chi2 = 0;
    double mean() const { return value / weight; }
  };
  const auto sums_with = [&](double scatter) {
    Sums sums;
    for (const Scale& s : scales) {
      const double weight = 1 / (own_variance(s) + scatter * scatter);
      sums.weight += weight;
      sums.square += weight * weight;
      sums.value += weight * s.mm_per_px;
    }
    for (const Scale& s : scales)
      sums.chi2 += std::pow(s.mm_per_px - sums.mean(), 2) / (own_variance(s) + scatter * scatter);
    return sums;
  };
  Sums sums = sums_with(0);
  pooled.chi2 = sums.chi2;
  const int dof = pooled.count - 1;
  if (dof > 0 && pooled.chi2 > chi2_of_one_in_thousand(dof)) {
    pooled.scatter = std::sqrt((sums.chi2 - dof) / (sums.weight - sums.square / sums.weight));
    sums = sums_with(pooled.scatter);
  }
  pooled.scale.mm_per_px = sums.mean();
  pooled.scale.sd = std::hypot(1 / std::sqrt(sums.weight), common_relative_sd * sums.mean());
  pooled.one_scale = pooled.scatter <= kRimScatter * sums.mean();
  return pooled;
}

namespace {

PlanePoint scaled(const Scale& scale, Point pixel) {
  PlanePoint out;
  out.mm = {scale.mm_per_px * pixel.x, -scale.mm_per_px * pixel.y};
  out.slope << scale.mm_per_px, 0, 0, -scale.mm_per_px;
  return out;
}

Scale times(const Scale& scale, double factor) {
  return {scale.mm_per_px * factor, scale.sd * factor, scale.source};
}

/// px^2
Eigen::Matrix2d covariance_of_mark(const MarkerPoint& marker) {
  if (marker.sigma_x > 0 && marker.sigma_y > 0) return covariance_of(marker);
  return marker.sigma * marker.sigma * Eigen::Matrix2d::Identity();
}

}  // namespace

PlaneGeometry::PlaneGeometry(const Scale& scale, ScalePlane plane, const std::optional<Parallax>& parallax)
    : part_(scale), marker_(scale) {
  if (!parallax) return;
  if (!(parallax->height_mm >= 0 && parallax->height_mm < parallax->distance_mm))
    throw std::invalid_argument("height_mm must not be negative and be less than working_distance_mm");
  const double nearer = 1 - parallax->height_mm / parallax->distance_mm;
  if (plane == ScalePlane::part_top)
    marker_ = times(scale, 1 / nearer);
  else
    part_ = times(scale, nearer);
}

PlaneGeometry::PlaneGeometry(const CameraCalibration& calibration, double height_mm)
    : calibration_(calibration), height_mm_(height_mm) {
  if (!(height_mm >= 0 && height_mm < calibration.distance_mm()))
    throw std::invalid_argument("height_mm must not be negative and be less than the camera's distance");
  marker_ = {calibration.mm_per_px, calibration.mm_per_px_sd, "calibration"};
  part_ = times(marker_, 1 - height_mm / calibration.distance_mm());
}

PlanePoint PlaneGeometry::part(Point pixel) const {
  return calibration_ ? calibration_->locate(pixel, height_mm_) : scaled(part_, pixel);
}

PlanePoint PlaneGeometry::marker(Point pixel) const {
  return calibration_ ? calibration_->locate(pixel, 0) : scaled(marker_, pixel);
}

std::vector<std::optional<PlacedPoint>> place_track(const Track& track, const PlaneGeometry& geometry,
                                                    double xi_axis_rad) {
  std::vector<std::optional<PlacedPoint>> out(track.points.size());
  const Eigen::Matrix2d turn = Eigen::Rotation2Dd(-xi_axis_rad).toRotationMatrix();
  std::optional<Eigen::Vector2d> origin;
  for (std::size_t k = 0; k < track.points.size(); ++k) {
    const TrackPoint& p = track.points[k];
    if (p.status != TrackStatus::ok || (track.has_marker && !p.marker)) continue;
    const PlanePoint part = geometry.part({p.x, p.y});
    PlacedPoint placed;
    placed.mm = part.mm;
    placed.covariance = part.slope * covariance_of(p) * part.slope.transpose();
    if (track.has_marker) {
      const PlanePoint marker = geometry.marker({p.marker->x, p.marker->y});
      placed.mm -= marker.mm;
      placed.covariance += marker.slope * covariance_of_mark(*p.marker) * marker.slope.transpose();
      placed.marker_mm = turn * marker.mm;
      placed.marker_sigma_mm = p.marker->sigma * std::sqrt(std::abs(marker.slope.determinant()));
    }
    if (!origin) origin = placed.mm;
    placed.mm = turn * (placed.mm - *origin);
    placed.covariance = turn * placed.covariance * turn.transpose();
    out[k] = placed;
  }
  return out;
}

}  // namespace tribotrack::vision
