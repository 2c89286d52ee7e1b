#include "vision/edge/rays.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "vision/kernels/dense.h"

namespace tribotrack::vision {
namespace {

/// Px; what lamps make of metal is anything between a streak and a slope. Lengths a few times apart span all.
constexpr double kInsideLengths[] = {2, 8, 40}, kOutsideLengths[] = {1.5, 6, 40};
constexpr double kFineLength = 0.7;  ///< px: texture that the lens just passes
constexpr double kBeyond = 4;        ///< px beyond the grid that the blur brings in
constexpr double kLeastVariance = 1e-12;

double normal(double t) {
  return 0.5 * std::erfc(-t / std::sqrt(2.0));
}

/// Share of each cell that lies inside an edge.
Eigen::ArrayXd share_inside(const Eigen::VectorXd& cells, double width, double edge) {
  return ((edge - cells.array()) / width + 0.5).max(0).min(1);
}

}  // namespace

RayFields::RayFields(const RayGrid& grid, double cell)
    : places_(static_cast<int>(grid.places())),
      cells_(static_cast<int>((places_ - 1 + 2 * kBeyond) / cell)),
      width_(cell) {
  place_ = Eigen::VectorXd::LinSpaced(places_, grid.offset(0), grid.offset(grid.places() - 1));
  cell_ = Eigen::VectorXd::LinSpaced(cells_, place_(0) - kBeyond + width_ / 2,
                                     place_(places_ - 1) + kBeyond - width_ / 2);
  const Eigen::ArrayXXd apart =
      (cell_.replicate(1, cells_) - cell_.transpose().replicate(cells_, 1)).array().abs();
  for (const double length : kInsideLengths) inside_.push_back((-apart / length).exp());
  for (const double length : kOutsideLengths) outside_.push_back((-apart / length).exp());
  fine_ = (-(apart / kFineLength).square() / 2).exp();
}

std::vector<Eigen::MatrixXd> RayFields::covariances(const RimOptics& optics, Beside beside) const {
  Eigen::MatrixXd blur(places_, cells_);
  for (int s = 0; s < places_; ++s)
    for (int c = 0; c < cells_; ++c) {
      const double off = place_(s) - cell_(c);
      blur(s, c) = normal((off + width_ / 2) / optics.blur) - normal((off - width_ / 2) / optics.blur);
    }
  const Eigen::ArrayXd part = share_inside(cell_, width_, optics.edge),
                       top = share_inside(cell_, width_, optics.edge - optics.chamfer);
  const auto seen = [&](const Eigen::ArrayXd& mask, const Eigen::MatrixXd& correlation) -> Eigen::MatrixXd {
    const Eigen::MatrixXd masked = blur * mask.matrix().asDiagonal();
    return masked * correlation * masked.transpose();
  };
  std::vector<Eigen::MatrixXd> fields;
  for (const auto& k : inside_) fields.push_back(seen(top, k));
  if (beside == Beside::whole_part)
    for (const auto& k : inside_) fields.push_back(seen(part, k));
  if (beside == Beside::chamfer) fields.push_back(seen(part - top, inside_.front()));
  for (const auto& k : outside_) fields.push_back(seen(1 - part, k));
  const Eigen::VectorXd strip = blur * (part - top).matrix();
  fields.emplace_back(strip * strip.transpose());
  fields.push_back(seen(top, fine_));
  return fields;
}

Eigen::MatrixXd field_covariance(const std::vector<Eigen::MatrixXd>& fields,
                                 const Eigen::VectorXd& variances) {
  Eigen::MatrixXd sum = variances(0) * fields[0];
  for (std::size_t q = 1; q < fields.size(); ++q) sum += variances(static_cast<Eigen::Index>(q)) * fields[q];
  return sum;
}

double fit_variances(const Eigen::MatrixXd& sample, const std::vector<Eigen::MatrixXd>& fields,
                     double noise_variance, int iterations, Eigen::VectorXd& variances) {
  const auto count = static_cast<Eigen::Index>(fields.size());
  const auto places = static_cast<double>(sample.rows());
  const Eigen::MatrixXd noise = noise_variance * Eigen::MatrixXd::Identity(sample.rows(), sample.rows());
  if (variances.size() != count)
    variances = Eigen::VectorXd::Constant(count, sample.trace() / places / static_cast<double>(count) + 1e-3);
  Eigen::MatrixXd inverse;
  double log_determinant = 0;
  for (int k = 0;; ++k) {
    inverse = inverse_of_spd(noise + field_covariance(fields, variances), log_determinant);
    if (k == iterations) break;
    const Eigen::MatrixXd x = inverse * sample * inverse;
    for (Eigen::Index q = 0; q < count; ++q) {
      const Eigen::MatrixXd& field = fields[static_cast<std::size_t>(q)];
      const double seen = x.cwiseProduct(field).sum(), expected = inverse.cwiseProduct(field).sum();
      variances(q) *= std::sqrt(std::max(seen, kLeastVariance) / std::max(expected, kLeastVariance));
    }
  }
  return log_determinant + inverse.cwiseProduct(sample).sum();
}

namespace {

/// Px: fields that end at the edge must be seen for a while; beyond some four blurs the ground, which moves
/// past, tells nothing of it.
constexpr int kInside = 7, kOutside = 4;
/// Of the radius: chamfers of discs reach a tenth, and the fields must be seen to end before them.
constexpr double kChamfer = 0.06;
constexpr int kLeastCore = 3;  ///< px about the centre that no ray enters
constexpr int kSplineReach = 4;

}  // namespace

RayGrid ray_grid(double radius) {
  RayGrid grid{.radius = radius, .inside = kInside, .outside = kOutside};
  grid.inside = std::max(grid.inside, static_cast<int>(std::lround(kInside + kChamfer * (radius - 30))));
  grid.inside = std::max(kLeastCore, std::min(grid.inside, static_cast<int>(radius) - kLeastCore));
  grid.azimuths = std::max(32, static_cast<int>(std::lround(2 * std::numbers::pi * radius / 16)) * 16);
  return grid;
}

RaySampler::RaySampler(const RayGrid& grid) : grid_(grid) {
  for (int p = 0; p < grid.azimuths; ++p) {
    const double phi = 2 * std::numbers::pi * p / grid.azimuths;
    for (std::size_t s = 0; s < grid.places(); ++s) {
      const double r = grid.radius + grid.offset(s);
      along_x_.push_back(static_cast<float>(r * std::cos(phi)));
      along_y_.push_back(static_cast<float>(r * std::sin(phi)));
    }
  }
  x_.resize(grid.size());
  y_.resize(grid.size());
}

Rect RaySampler::window(const Point& centre) const {
  const double reach = grid_.reach() + kSplineReach;
  const int x0 = static_cast<int>(std::floor(centre.x - reach)),
            y0 = static_cast<int>(std::floor(centre.y - reach));
  return {x0, y0, static_cast<int>(std::ceil(centre.x + reach)) - x0 + 1,
          static_cast<int>(std::ceil(centre.y + reach)) - y0 + 1};
}

void RaySampler::sample(const QuinticSpline& spline, const Rect& window, const Point& centre,
                        const RayLevels& out) {
  const auto x0 = static_cast<float>(centre.x - window.x), y0 = static_cast<float>(centre.y - window.y);
  for (std::size_t i = 0; i < x_.size(); ++i) {
    x_[i] = x0 + along_x_[i];
    y_[i] = y0 + along_y_[i];
  }
  spline.sample_places(x_, y_, out.level, out.slope_x, out.slope_y);
}

}  // namespace tribotrack::vision
